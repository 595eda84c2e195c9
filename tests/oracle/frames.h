// What makes random frames for the oracles: a line a frame, from a seed.
#pragma once

#include <charconv>
#include <cstdint>
#include <fmt/format.h>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/random.h"
#include "devices/protocol/payload.h"

namespace virtdrive {

/// Values whose bytes are half random and half on an edge: signs, and what begins or ends a frame.
inline protocol::Values random_values(std::span<const protocol::Field> fields,
                                      protocol::ByteOrder order,
                                      std::span<const std::uint8_t> frame_marks,
                                      RandomStream& random) {
  std::vector<std::uint8_t> edges = {0x00, 0x01, 0x7F, 0x80, 0xFE, 0xFF};
  edges.insert(edges.end(), frame_marks.begin(), frame_marks.end());
  std::vector<std::uint8_t> bytes(protocol::width(fields));
  for (std::uint8_t& byte : bytes) {
    const std::uint64_t bits = random.bits();
    byte = (bits & 0x100) != 0 ? edges[bits % edges.size()] : static_cast<std::uint8_t>(bits);
  }
  return protocol::unpack(fields, order, bytes);
}

/// " 1 130 1000"
inline std::string text(const protocol::Values& values) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) text += fmt::format(" {}", values[i]);
  return text;
}

/// main() of PROGRAM COUNT SEED; the exit code.
inline int print_frames(int argc, char** argv, std::string (*line)(RandomStream&)) {
  const auto number = [](std::string_view text, std::uint64_t& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
  };
  std::uint64_t count = 0;
  std::uint64_t seed = 0;
  if (argc != 3 || !number(argv[1], count) || !number(argv[2], seed)) {
    fmt::print(stderr, "usage: {} COUNT SEED\n", argv[0]);
    return 2;
  }
  RandomStream random = Seed{seed}.stream("frames");
  for (std::uint64_t i = 0; i < count; ++i) fmt::print("{}", line(random));
  return 0;
}

}  // namespace virtdrive
