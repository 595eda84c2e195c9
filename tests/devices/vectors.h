// Golden frames: name,direction,hex,note,source with quoted notes.
#pragma once

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/check.h"

namespace virtdrive {

struct Vector {
  std::string name;
  std::string direction;  // "request" or "response"
  std::vector<std::uint8_t> bytes;
};

inline std::vector<std::uint8_t> from_hex(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::uint8_t> bytes;
  for (std::string byte; stream >> byte;) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(byte, nullptr, 16)));
  }
  return bytes;
}

/// Of a file in tests/data. Empty if it cannot be read: the caller asserts that it is not.
inline std::vector<Vector> read_vectors(const std::string& file) {
  std::ifstream stream(std::string(VIRTDRIVE_TEST_DATA) + "/" + file);
  std::vector<Vector> vectors;
  std::string line;
  std::getline(stream, line);  // the header
  while (std::getline(stream, line)) {
    std::istringstream row(line);
    Vector vector;
    std::string hex;
    std::getline(row, vector.name, ',');
    std::getline(row, vector.direction, ',');
    std::getline(row, hex, ',');
    vector.bytes = from_hex(hex);
    vectors.push_back(std::move(vector));
  }
  return vectors;
}

inline bool is_request(const Vector& vector) {
  return vector.direction == "request";
}

/// One frame by its name. Aborts if there is none: a test must not pass on nothing.
inline std::vector<std::uint8_t> golden_frame(const std::vector<Vector>& vectors,
                                              std::string_view name, std::string_view direction) {
  for (const Vector& vector : vectors) {
    if (vector.name == name && vector.direction == direction) return vector.bytes;
  }
  VIRTDRIVE_CHECK(false, "no {} {}", direction, name);
  return {};
}

}  // namespace virtdrive
