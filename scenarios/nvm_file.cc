#include "scenarios/nvm_file.h"

#include <boost/crc.hpp>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>

#include "core/check.h"
#include "pty/file_descriptor.h"

namespace virtdrive {
namespace {

constexpr std::string_view kMagic = "virtdrive-nvm";
constexpr std::size_t kLongestFile = 1 << 20;

std::uint32_t crc32(std::string_view text) {
  boost::crc_32_type crc;
  crc.process_bytes(text.data(), text.size());
  return crc.checksum();
}

std::optional<std::vector<std::uint8_t>> from_hex(std::string_view text) {
  std::vector<std::uint8_t> bytes;
  if (text.size() % 2 != 0) return std::nullopt;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    std::uint8_t byte = 0;
    const char* const last = text.data() + i + 2;
    const auto [end, error] = std::from_chars(text.data() + i, last, byte, 16);
    if (error != std::errc{} || end != last) return std::nullopt;
    bytes.push_back(byte);
  }
  return bytes;
}

// The file's text; nothing if there is no file.
std::optional<std::string> contents(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return std::nullopt;
  if (!std::filesystem::is_regular_file(status)) {
    throw SetupError(fmt::format("--nvm {}: is not a file", path));
  }
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw SetupError(fmt::format("--nvm {}: cannot be read: {}", path, std::strerror(errno)));
  }
  std::string text(kLongestFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

bool write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// The blocks of a file's body, which begins behind the first line; nothing if it is damaged.
template <class Blocks>
std::optional<Blocks> parse(const std::string& text) {
  const std::size_t trailer = text.rfind("crc32 ");
  if (trailer == std::string::npos) return std::nullopt;
  if (text.substr(trailer) != fmt::format("crc32 {:08x}\n", crc32(text.substr(0, trailer)))) {
    return std::nullopt;
  }
  Blocks blocks;
  std::istringstream lines(text.substr(0, trailer));
  std::string line, word, name, hex;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    if (!(words >> word >> name >> hex) || word != "block") return std::nullopt;
    auto bytes = from_hex(hex);
    if (!bytes) return std::nullopt;
    blocks.insert_or_assign(name, std::move(*bytes));
  }
  return blocks;
}

}  // namespace

NvmFile::NvmFile(const std::string& path, std::string_view drive, const NoteListener& notes)
    : path_(path), drive_(drive) {
  const auto text = contents(path);
  if (!text) {
    const auto folder = std::filesystem::absolute(path).parent_path();
    if (!std::filesystem::is_directory(folder)) {
      throw SetupError(fmt::format("--nvm {}: the folder {} is not there", path, folder.string()));
    }
    return;
  }
  std::istringstream first_line(text->substr(0, text->find('\n')));
  std::string magic, owner;
  int version = 0;
  first_line >> magic >> version >> owner;
  if (!text->empty() && magic != kMagic) {
    throw SetupError(
        fmt::format("--nvm {}: is not a memory of virtdrive; name another file", path));
  }
  if (!owner.empty() && (version != 1 || owner != drive_)) {
    throw SetupError(
        fmt::format("--nvm {}: is the memory of '{}' (format {}), not of {}; name another file",
                    path, owner, version, drive_));
  }
  auto blocks = parse<Blocks>(*text);
  if (blocks)
    blocks_ = std::move(*blocks);
  else if (notes)
    notes(fmt::format("{} is damaged; the drive starts with factory settings", path));
}

std::optional<std::vector<std::uint8_t>> NvmFile::read(std::string_view block) {
  const auto it = blocks_.find(block);
  if (it == blocks_.end()) return std::nullopt;
  return it->second;
}

bool NvmFile::write(std::string_view block, std::span<const std::uint8_t> bytes) {
  Blocks changed = blocks_;
  changed.insert_or_assign(std::string(block), std::vector(bytes.begin(), bytes.end()));
  return save(changed);
}

bool NvmFile::erase() {
  return save({});
}

bool NvmFile::save(const Blocks& blocks) {
  std::string text = fmt::format("{} 1 {}\n", kMagic, drive_);
  for (const auto& [name, bytes] : blocks) {
    text += fmt::format("block {} {:02x}\n", name, fmt::join(bytes, ""));
  }
  text += fmt::format("crc32 {:08x}\n", crc32(text));

  const std::string fresh = path_ + ".new";
  {
    const FileDescriptor file{
        ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
    if (!file || !write_all(file.get(), text) || ::fsync(file.get()) != 0) return false;
  }
  if (::rename(fresh.c_str(), path_.c_str()) != 0) return false;
  const auto folder = std::filesystem::absolute(path_).parent_path();
  const FileDescriptor directory{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (directory) ::fsync(directory.get());
  blocks_ = blocks;
  return true;
}

}  // namespace virtdrive
