// A memory's file may hold anything: it is loaded, reported as damaged, or refused with one line;
// what was loaded is written and read back the same. A first byte that is odd has what follows
// framed by a header and a checksum that fit, or no input would get far.
#include <boost/crc.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <string>
#include <unistd.h>

#include "core/check.h"
#include "scenarios/nvm_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace virtdrive {
namespace {

// In memory where there is such a file system: a fuzzer writes thousands of files a second.
std::filesystem::path scratch_folder() {
  const std::filesystem::path memory = "/dev/shm";
  return std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
}

class ScratchFile {
 public:
  ScratchFile()
      : path_((scratch_folder() / fmt::format("virtdrive-nvm-fuzz-{}", getpid())).string()) {}
  ~ScratchFile() { std::filesystem::remove(path_); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  const std::string& path() const { return path_; }
  void write(std::string_view text) const {
    std::ofstream(path_, std::ios::binary).write(text.data(), std::ssize(text));
  }
  std::string text() const {
    std::ifstream stream(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  std::string path_;
};

std::string sealed(std::string_view body) {
  std::string text = fmt::format("virtdrive-nvm 1 toshiba-mcu\n{}", body);
  boost::crc_32_type crc;
  crc.process_bytes(text.data(), text.size());
  return text + fmt::format("crc32 {:08x}\n", crc.checksum());
}

void load(const std::string& path) {
  bool damaged = false;
  try {
    NvmFile memory(path, "toshiba-mcu", [&](std::string_view note) {
      VIRTDRIVE_CHECK(note.find(path) != note.npos, "a note that names no file: {}", note);
      damaged = true;
    });
    const auto block = memory.read("channel1");
    VIRTDRIVE_CHECK(!(damaged && block), "a damaged file was loaded");
    VIRTDRIVE_CHECK(memory.write("fuzz", std::vector<std::uint8_t>{1, 2, 3}), "not written");
    NvmFile again(path, "toshiba-mcu", [](std::string_view note) {
      VIRTDRIVE_CHECK(false, "what was just written is damaged: {}", note);
    });
    VIRTDRIVE_CHECK(again.read("channel1") == block, "a block has changed");
    VIRTDRIVE_CHECK(again.read("fuzz") == (std::vector<std::uint8_t>{1, 2, 3}), "a block is gone");
  } catch (const SetupError& error) {
    const std::string_view text = error.what();
    VIRTDRIVE_CHECK(text.find('\n') == text.npos, "more than a line: {}", text);
  }
}

}  // namespace

std::vector<std::vector<std::uint8_t>> fuzz_seeds() {
  const ScratchFile file;
  file.write("");
  NvmFile memory(file.path(), "toshiba-mcu", nullptr);
  memory.write("channel0", std::vector<std::uint8_t>(200, 0x5A));
  memory.write("channel1", std::vector<std::uint8_t>{1, 2, 3});
  const std::string text = " " + file.text();
  const std::string body =
      "\x01"
      "block channel1 0102\nblock channel2 ff\n";
  return {{text.begin(), text.end()}, {body.begin(), body.end()}, {}};
}

}  // namespace virtdrive

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace virtdrive;
  static const ScratchFile file;
  const std::string text(data, data + size);
  const std::string rest = text.empty() ? text : text.substr(1);
  file.write(!text.empty() && (text[0] & 1) != 0 ? sealed(rest) : rest);
  load(file.path());
  return 0;
}
