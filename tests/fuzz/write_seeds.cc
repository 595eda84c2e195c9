// Writes a fuzz target's seeds to a folder, a file each.
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>

#include "tests/fuzz/fuzz_target.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: {} FOLDER\n", argv[0]);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const auto& seed : virtdrive::fuzz_seeds()) {
    std::ofstream stream(folder / fmt::format("seed{}", number++), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(seed.data()),
                 static_cast<std::streamsize>(seed.size()));
    if (!stream) return 1;
  }
  return number > 0 ? 0 : 1;
}
