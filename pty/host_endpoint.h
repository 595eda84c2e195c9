// What joins the host end of a line to the world outside: a pseudo-terminal, a TCP port or a real
// serial port. The runner asks three things of it.
#pragma once

namespace virtdrive {

class HostEndpoint {
 public:
  virtual ~HostEndpoint() = default;

  /// Readable, as poll() means it, when the world outside has something to say. The same for life;
  /// an endpoint with several descriptors returns an epoll set of its own.
  virtual int fd() const = 0;
  /// Takes in what has come. The loop stands at the instant at which it came. Never blocks.
  virtual void readable() = 0;
  /// Hands over what the line has delivered since. Never blocks.
  virtual void flush() = 0;
};

}  // namespace virtdrive
