// What a drive keeps when its power goes: blocks of bytes by name, in an EEPROM or a flash.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace virtdrive {

class NonVolatileMemory {
 public:
  virtual ~NonVolatileMemory() = default;

  /// A block as it was written last; nothing if it never was.
  virtual std::optional<std::vector<std::uint8_t>> read(std::string_view block) = 0;
  /// Replaces a block, wholly or not at all. False if it could not be kept.
  virtual bool write(std::string_view block, std::span<const std::uint8_t> bytes) = 0;
  /// Forgets all blocks. False if that failed.
  virtual bool erase() = 0;
};

/// Lives as long as the process: what a bench has when no file is named.
class MemoryInProcess final : public NonVolatileMemory {
 public:
  std::optional<std::vector<std::uint8_t>> read(std::string_view block) override {
    const auto it = blocks_.find(block);
    if (it == blocks_.end()) return std::nullopt;
    return it->second;
  }
  bool write(std::string_view block, std::span<const std::uint8_t> bytes) override {
    blocks_.insert_or_assign(std::string(block), std::vector(bytes.begin(), bytes.end()));
    return true;
  }
  bool erase() override {
    blocks_.clear();
    return true;
  }

 private:
  std::map<std::string, std::vector<std::uint8_t>, std::less<>> blocks_;
};

}  // namespace virtdrive
