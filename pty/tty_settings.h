// A terminal's settings by way of termios2, which carries any baud rate as a number.
//
// In a file of its own because <asm/termbits.h> and <termios.h> cannot be included together.
#pragma once

#include <cstdint>

namespace virtdrive {

struct TtySettings {
  int baud = 0;  // bit/s; 0: hung up (B0)
  int stop_bits = 1;

  friend bool operator==(const TtySettings&, const TtySettings&) = default;
};

/// What a host has set the slave of this pseudo-terminal master to. Leaves CLOCAL cleared, so that
/// the next program that asks for it, with or without a parity, changes something (see .cc).
TtySettings inspect_host(int master);

enum class RawFor : std::uint8_t {
  kHost,    // what a host program asks for
  kNobody,  // raw as well, but with a combination of flags that no host asks for (see .cc)
};

/// 8 data bits, no echo, no translation, no flow control. False (errno) if `fd` is no terminal.
bool set_raw(int fd, const TtySettings& settings, RawFor whom);

/// Throws away what the terminal's user has not read yet.
void discard_unread(int fd);

}  // namespace virtdrive
