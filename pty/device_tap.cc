#include "pty/device_tap.h"

#include "core/check.h"

namespace virtdrive {
namespace {

LineSettings line_settings(const SerialLine& line, const TtySettings& tty) {
  return {.timing = line.settings().timing,
          .baud = tty.baud,
          .data_bits = tty.data_bits,
          .parity = tty.parity,
          .stop_bits = tty.stop_bits};
}

}  // namespace

DeviceTap::DeviceTap(SerialLine& line, const std::string& address, const TtySettings& settings)
    : port_(address, settings),
      settings_(settings),
      end_(line.add_device(line_settings(line, settings))) {
  end_.attach(*this);
}

DeviceTap::~DeviceTap() {
  end_.detach();
}

void DeviceTap::follow(const HostSettings& host) {
  TtySettings wanted = settings_;
  if (host.baud > 0) wanted.baud = host.baud;
  if (host.stop_bits > 0) wanted.stop_bits = host.stop_bits;
  if (host.data_bits > 0) wanted.data_bits = host.data_bits;
  wanted.parity = host.parity.value_or(wanted.parity);
  if (wanted == settings_) return;
  flush();  // was said as it was set before
  port_.set(wanted);
  settings_ = wanted;
  LineSettings line = end_.settings();
  line.baud = wanted.baud;
  line.data_bits = wanted.data_bits;
  line.parity = wanted.parity;
  line.stop_bits = wanted.stop_bits;
  end_.set_settings(line);
}

void DeviceTap::readable() {
  constexpr std::size_t kMost = 4096;  // at once
  end_.send(port_.read(kMost, std::chrono::nanoseconds{0}));
}

void DeviceTap::flush() {
  if (pending_.empty()) return;
  port_.write(pending_);
  pending_.clear();
}

}  // namespace virtdrive
