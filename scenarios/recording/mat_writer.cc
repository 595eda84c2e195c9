#include "scenarios/recording/mat_writer.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <matio.h>

#include "core/check.h"

namespace virtdrive {
namespace {

struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

// The text of the header, which matio would date. Its field has 116 bytes, filled with spaces.
std::string header_text() {
  return fmt::format("{:<115}", "MATLAB 5.0 MAT-file, written by virtdrive");
}

Variable make_text(const std::string& name, std::string& text) {
  std::size_t dimensions[] = {text.empty() ? 0U : 1U, text.size()};
  return Variable(
      Mat_VarCreate(name.c_str(), MAT_C_CHAR, MAT_T_UINT8, 2, dimensions, text.data(), 0));
}

}  // namespace

std::vector<std::string> mat_names(const std::vector<Column>& columns) {
  std::vector<std::string> taken = {"time", "units"};
  for (const Column& column : columns) {
    std::string name = column.name;
    for (char& c : name) {
      if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    }
    // A name starts with a letter.
    if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0]))) name.insert(0, "s");
    while (std::ranges::find(taken, name) != taken.end()) name += '_';
    taken.push_back(std::move(name));
  }
  taken.erase(taken.begin(), taken.begin() + 2);
  return taken;
}

void MatWriter::CloseMat::operator()(_mat_t* file) const {
  Mat_Close(file);
}

MatWriter::MatWriter(const std::string& path, const std::vector<Column>& columns,
                     std::size_t maximum_values)
    : path_(path), columns_(columns), maximum_values_(maximum_values), values_(columns.size()) {
  errno = 0;
  file_.reset(Mat_CreateVer(path.c_str(), header_text().c_str(), MAT_FT_MAT5));
  if (!file_) {
    throw SetupError(fmt::format("--record {}: cannot be written: {}", path, std::strerror(errno)));
  }
}

void MatWriter::write(SimTime time, std::span<const double> values) {
  if ((time_.size() + 1) * (values.size() + 1) > maximum_values_) {
    close();
    throw SetupError(fmt::format(
        "--record {}: full at {:.3f} s: a MAT file is limited to {} numbers; record to .csv or "
        ".vcd, fewer signals, or at a longer --interval",
        path_, seconds(time), maximum_values_));
  }
  time_.push_back(seconds(time));
  for (std::size_t i = 0; i < values.size(); ++i) values_[i].push_back(values[i]);
}

void MatWriter::fail_to_write() {
  throw SetupError(fmt::format("--record {}: not all of it could be written", path_));
}

void MatWriter::write_vector(const std::string& name, std::vector<double>& values) {
  std::size_t dimensions[] = {values.size(), 1};
  const Variable variable(Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dimensions,
                                        values.data(), MAT_F_DONT_COPY_DATA));
  if (!variable || Mat_VarWrite(file_.get(), variable.get(), MAT_COMPRESSION_NONE) != 0) {
    fail_to_write();
  }
}

void MatWriter::write_units() {
  const std::vector<std::string> names = mat_names(columns_);
  std::vector<const char*> fields = {"time"};
  for (const std::string& name : names) fields.push_back(name.c_str());
  std::size_t dimensions[] = {1, 1};
  const Variable units(Mat_VarCreateStruct("units", 2, dimensions, fields.data(),
                                           static_cast<unsigned>(fields.size())));
  if (!units) fail_to_write();
  std::string second = "s";
  Mat_VarSetStructFieldByIndex(units.get(), 0, 0, make_text("time", second).release());
  for (std::size_t i = 0; i < names.size(); ++i) {
    Mat_VarSetStructFieldByIndex(units.get(), i + 1, 0,
                                 make_text(names[i], columns_[i].unit).release());
  }
  if (Mat_VarWrite(file_.get(), units.get(), MAT_COMPRESSION_NONE) != 0) fail_to_write();
}

void MatWriter::close() {
  if (!file_) return;
  const std::vector<std::string> names = mat_names(columns_);
  write_vector("time", time_);
  for (std::size_t i = 0; i < names.size(); ++i) write_vector(names[i], values_[i]);
  write_units();
  file_.reset();
  check_written();
}

// matio (1.5.23) does not tell when a write fails, on a full disk for one: what counts is what can
// be read back.
void MatWriter::check_written() {
  const std::unique_ptr<mat_t, CloseMat> file(Mat_Open(path_.c_str(), MAT_ACC_RDONLY));
  if (!file) fail_to_write();
  const auto check = [&](const std::string& name, const std::vector<double>& values) {
    const Variable read(Mat_VarRead(file.get(), name.c_str()));
    const std::size_t size = values.size() * sizeof(double);
    if (!read || read->nbytes != size) fail_to_write();
    if (size > 0 && std::memcmp(read->data, values.data(), size) != 0) fail_to_write();
  };
  const std::vector<std::string> names = mat_names(columns_);
  check("time", time_);
  for (std::size_t i = 0; i < names.size(); ++i) check(names[i], values_[i]);
  if (!Variable(Mat_VarRead(file.get(), "units"))) fail_to_write();
}

}  // namespace virtdrive
