#include "scenarios/recording/vcd_writer.h"

#include <bit>
#include <fmt/format.h>
#include <iterator>
#include <utility>

namespace virtdrive {
namespace {

// Identifier codes are made of the printable characters '!' ... '~' (clause 18.2.1).
std::string identifier_code(std::size_t index) {
  constexpr std::size_t kCharacters = '~' - '!' + 1;
  std::string code;
  do {
    code += static_cast<char>('!' + index % kCharacters);
    index /= kCharacters;
  } while (index > 0);
  return code;
}

// component.quantity
std::pair<std::string_view, std::string_view> split(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return {"bench", name};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace

VcdWriter::VcdWriter(const std::string& path, const std::vector<Column>& columns)
    : file_("--record", path) {
  text_ = "$version virtdrive $end\n$timescale 1 ns $end\n";
  for (const Column& column : columns) {
    if (column.unit.empty()) continue;
    text_ += fmt::format("$comment {} in {} $end\n", column.name, column.unit);
  }
  // A scope may be opened again: the columns keep their order.
  std::string_view open;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto [scope, variable] = split(columns[i].name);
    if (scope != open) {
      if (!open.empty()) text_ += "$upscope $end\n";
      text_ += fmt::format("$scope module {} $end\n", scope);
      open = scope;
    }
    codes_.push_back(identifier_code(i));
    text_ += fmt::format("$var real 64 {} {} $end\n", codes_.back(), variable);
  }
  if (!open.empty()) text_ += "$upscope $end\n";
  text_ += "$enddefinitions $end\n";
  file_.write(text_);
}

void VcdWriter::write_time() {
  if (time_written_) return;
  fmt::format_to(std::back_inserter(text_), "#{}\n", now_.time_since_epoch().count());
  time_written_ = true;
}

void VcdWriter::write(SimTime time, std::span<const double> values) {
  const bool first = last_.empty();
  now_ = time;
  time_written_ = false;
  text_.clear();
  if (first) {
    write_time();
    text_ += "$dumpvars\n";
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!first && same_bits(values[i], last_[i])) continue;
    write_time();
    fmt::format_to(std::back_inserter(text_), "r{} {}\n", values[i], codes_[i]);
  }
  if (first) text_ += "$end\n";
  last_.assign(values.begin(), values.end());
  file_.write(text_);
}

void VcdWriter::close() {
  text_.clear();
  write_time();
  if (!text_.empty()) file_.write(text_);
  file_.close();
}

}  // namespace virtdrive
