// A file that the user asked for by an option ("--record", "--report"): opened anew, written
// through a buffer, errors told with the option's name.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace virtdrive {

class OutputFile {
 public:
  /// Opens `path` anew; SetupError if it cannot be written.
  OutputFile(std::string_view option, const std::string& path);

  /// An error is kept until close().
  void write(std::string_view text);
  /// Hands what was written to the system: a kill takes no more than what comes after.
  void flush() { std::fflush(file_.get()); }
  /// SetupError if not all of it could be written.
  void close();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::string what_;  // "--record run.csv"
  std::unique_ptr<std::FILE, CloseFile> file_;
};

}  // namespace virtdrive
