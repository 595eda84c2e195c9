// A folder for one test, removed with what is in it.
#pragma once

#include <filesystem>
#include <string>

#include "core/check.h"

namespace virtdrive {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = std::filesystem::temp_directory_path() / "virtdrive-test-XXXXXX";
    VIRTDRIVE_CHECK(mkdtemp(name.data()) != nullptr, "mkdtemp {}", name);
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace virtdrive
