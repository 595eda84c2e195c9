// A real device at the device end of a line: what a host at the other end says goes to the device's
// port, and what the device says comes back. With an endpoint for the host, the line is a tap
// between the two, and everything that listens to lines can listen in.
//
// The line should be ideal: it only passes on, and the real line's character times have passed
// already. The port is set as the host sets its own end, as far as that can be seen.
#pragma once

#include <string>
#include <vector>

#include "pty/host_endpoint.h"
#include "pty/host_port.h"
#include "pty/serial_line.h"

namespace virtdrive {

class DeviceTap final : public HostEndpoint, public SerialReceiver {
 public:
  /// Adds a device to the line, which must outlive the tap. `address` as of a HostPort; SetupError
  /// as there.
  DeviceTap(SerialLine& line, const std::string& address, const TtySettings& settings);
  DeviceTap(const DeviceTap&) = delete;
  DeviceTap& operator=(const DeviceTap&) = delete;
  ~DeviceTap() override;

  /// The host has set its end so; what it does not say stays. SetupError if the port cannot.
  void follow(const HostSettings& host);

  int fd() const override { return port_.fd(); }
  /// SetupError if the port is gone.
  void readable() override;
  /// Waits for up to a second if the port takes nothing; then SetupError.
  void flush() override;
  void receive(std::uint8_t byte) override { pending_.push_back(byte); }

 private:
  HostPort port_;
  TtySettings settings_;
  LineEnd& end_;
  std::vector<std::uint8_t> pending_;  // for the device
};

}  // namespace virtdrive
