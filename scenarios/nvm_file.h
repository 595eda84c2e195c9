// A drive's non-volatile memory in a file, so that it outlives the program.
//
//   virtdrive-nvm 1 toshiba-mcu
//   block channel1 030a1000...
//   crc32 1f2e3d4c
//
// Each change writes a new file beside the old one, brings it to the disk and renames it: whatever
// happens in between, the old or the new set is there, never a mix. A damaged or cut file is
// reported and counts as empty; a file that is not ours, or another drive's, is refused and never
// written to.
#pragma once

#include <string>
#include <string_view>

#include "core/nvm.h"
#include "devices/wire_log.h"

namespace virtdrive {

class NvmFile final : public NonVolatileMemory {
 public:
  /// `path` need not exist yet. SetupError if it is not ours, another drive's, or unreadable.
  NvmFile(const std::string& path, std::string_view drive, const NoteListener& notes);

  std::optional<std::vector<std::uint8_t>> read(std::string_view block) override;
  bool write(std::string_view block, std::span<const std::uint8_t> bytes) override;
  bool erase() override;

 private:
  using Blocks = std::map<std::string, std::vector<std::uint8_t>, std::less<>>;

  bool save(const Blocks& blocks);

  std::string path_;
  std::string drive_;
  Blocks blocks_;
};

}  // namespace virtdrive
