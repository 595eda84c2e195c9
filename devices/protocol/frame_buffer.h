// The bytes that a decoder holds back until they are a frame: bounded, in order.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/check.h"
#include "devices/protocol/table.h"

namespace virtdrive::protocol {

template <std::size_t kCapacity>
class FrameBuffer {
 public:
  std::span<const std::uint8_t> bytes() const { return std::span(data_).first(size_); }
  std::uint8_t operator[](std::size_t i) const { return bytes()[i]; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool full() const { return size_ == kCapacity; }

  void push(std::uint8_t byte) {
    VIRTDRIVE_CHECK(!full(), "a frame of more than {} bytes", kCapacity);
    data_[size_++] = byte;
  }
  /// Forgets the first n bytes.
  void drop(std::size_t n) {
    VIRTDRIVE_CHECK(n <= size_, "{} of {} bytes", n, size_);
    std::copy(data_.begin() + n, data_.begin() + size_, data_.begin());
    size_ -= n;
  }
  void clear() { size_ = 0; }

 private:
  std::array<std::uint8_t, kCapacity> data_{};
  std::size_t size_ = 0;
};

/// Bytes of the whole frame where a length byte rules; 0 while that byte has not come.
constexpr std::size_t frame_size(const Framing& framing, std::span<const std::uint8_t> bytes) {
  return bytes.size() > framing.length_at ? bytes[framing.length_at] + framing.overhead : 0;
}

}  // namespace virtdrive::protocol
