#include "scenarios/recording/recording_writer.h"

#include <fmt/format.h>

#include "core/check.h"
#include "scenarios/recording/csv_writer.h"
#include "scenarios/recording/mat_writer.h"
#include "scenarios/recording/vcd_writer.h"

namespace virtdrive {
namespace {

template <typename Writer>
std::unique_ptr<RecordingWriter> open(const std::string& path, const std::vector<Column>& columns) {
  return std::make_unique<Writer>(path, columns);
}

struct Format {
  std::string_view ending;
  std::unique_ptr<RecordingWriter> (*open)(const std::string&, const std::vector<Column>&);
};

constexpr Format kFormats[] = {
    {".csv", open<CsvWriter>}, {".vcd", open<VcdWriter>}, {".mat", open<MatWriter>}};

const Format& find_format(std::string_view path) {
  std::string known;
  for (const Format& format : kFormats) {
    if (path.ends_with(format.ending)) return format;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", format.ending);
  }
  throw SetupError(fmt::format("--record {}: the file's name must end in one of {}", path, known));
}

}  // namespace

std::unique_ptr<RecordingWriter> open_recording(const std::string& path,
                                                const std::vector<Column>& columns) {
  return find_format(path).open(path, columns);
}

void check_recording_format(std::string_view path) {
  find_format(path);
}

}  // namespace virtdrive
