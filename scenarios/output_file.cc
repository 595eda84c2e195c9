#include "scenarios/output_file.h"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>

#include "core/check.h"

namespace virtdrive {

OutputFile::OutputFile(std::string_view option, const std::string& path)
    : what_(fmt::format("{} {}", option, path)), file_(std::fopen(path.c_str(), "w")) {
  if (!file_) {
    throw SetupError(fmt::format("{}: cannot be written: {}", what_, std::strerror(errno)));
  }
}

void OutputFile::write(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), file_.get());
}

void OutputFile::close() {
  if (!file_) return;
  const bool good = std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0;
  file_.reset();
  if (!good) throw SetupError(fmt::format("{}: not all of it could be written", what_));
}

}  // namespace virtdrive
