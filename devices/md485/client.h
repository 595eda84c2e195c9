// A host's side of the MD protocol, made from the same rows as the controller.
#pragma once

#include <cstdint>

#include "devices/host_transport.h"
#include "devices/md485/codec.h"

namespace virtdrive::md485 {

class Client {
 public:
  explicit Client(HostTransport& transport, Route route = {},
                  SimDuration patience = std::chrono::milliseconds(500))
      : transport_(transport), route_(route), patience_(patience) {}

  std::uint8_t id() const { return route_.id; }
  void set_id(std::uint8_t id) { route_.id = id; }

  /// Asks for a PID's data (PID 4, or 164 where an index is told); ClientError if the controller
  /// does not answer.
  protocol::Values read(const ParameterRow& row);
  protocol::Values read(const ParameterRow& row, std::uint8_t index);
  /// Not answered: there is nothing to wait for. The check byte, where a row wants one, is added.
  void write(const ParameterRow& row, const protocol::Values& values);
  /// Writes, and reads back what it holds now: DriveRefused, with the first number that differs, if
  /// that is not what was written (a controller says nothing itself; numbers out of range go to the
  /// nearest end). `values` begin with the index where a row has one.
  void set(const ParameterRow& row, const protocol::Values& values);
  void command(const CommandRow& row, const protocol::Values& values);

  /// The next frame of this PID; others are passed over. ClientError if none comes.
  protocol::Values receive(const ParameterRow& row);

 private:
  void follow_id(std::uint8_t id);

  HostTransport& transport_;
  Route route_;
  SimDuration patience_;
};

}  // namespace virtdrive::md485
