// The rows of the parameter table joined to the controller: every read and write of a PID, and what
// is kept of them when the power goes.
#pragma once

#include <cstdint>
#include <optional>

#include "core/nvm.h"
#include "devices/md485/model_table.h"
#include "devices/protocol/payload.h"
#include "devices/wire_log.h"
#include "firmware_models/md/controller.h"

namespace virtdrive::md485 {

/// The settings that `memory` holds for this model; the model's own where it holds none, and, with
/// a note, where they are damaged or another model's.
md::Settings stored_settings(const md::Model& model, NonVolatileMemory& memory,
                             const NoteListener& notes = nullptr);

class Parameters {
 public:
  Parameters(md::Controller& controller, const ModelTable& table, NonVolatileMemory& memory)
      : controller_(controller), table_(table), memory_(memory) {}

  /// What the PID's frame holds now. `index` counts for PID 225, 226 and 227. Nothing for a PID
  /// that the model has not, or that is not to be read.
  std::optional<protocol::Values> read(std::uint8_t pid, std::uint8_t index = 1) const;

  /// `values` as the fields of write_fields(). False if it changed nothing: a PID that is not to be
  /// written, a wrong check, a number out of range. Numbers of two bytes and more are put to the
  /// nearest end of their range instead.
  bool write(std::uint8_t pid, const protocol::Values& values);

  /// PID 3: everything to the model's defaults but ID, baud rate and CAN bit rate.
  void to_defaults();
  void change(const md::Settings& settings);

 private:
  md::Controller& controller_;
  const ModelTable& table_;
  NonVolatileMemory& memory_;
};

}  // namespace virtdrive::md485
