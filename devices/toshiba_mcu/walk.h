// What the table walk must know of MCU Motor Studio's telegrams.
#pragma once

#include "devices/protocol/walk.h"
#include "devices/toshiba_mcu/table.h"

namespace virtdrive::toshiba_mcu {

/// Motors are started for some ten milliseconds, with the target speed that the drive has. Commands
/// that start, stop, store and clear come last.
class WalkDialect final : public protocol::Dialect {
 public:
  const ProtocolTable& table() const override { return kTable; }

  std::optional<protocol::Values> sample(const CommandRow& row,
                                         std::uint8_t channel) const override;
  protocol::Bytes command(const CommandRow& row, const protocol::Values& request) const override;
  protocol::Bytes read(const ParameterRow& row, std::uint8_t channel) const override;
  protocol::Bytes write(const ParameterRow& row, std::uint8_t channel,
                        protocol::Setting setting) const override;
  protocol::Bytes probe() const override;
  std::optional<protocol::Bytes> spoil(const protocol::Bytes& request,
                                       protocol::Damage damage) const override;
  protocol::Bytes noise() const override;
  protocol::Bytes resynchronise() const override;

  std::optional<protocol::Answer> decode(std::span<const std::uint8_t> request,
                                         std::span<const std::uint8_t> reply) const override;
  std::optional<protocol::Setting> setting(const protocol::Values& reply) const override;

  protocol::Answer refusal(protocol::Refusal refusal) const override;
  protocol::Answer reaction(protocol::Damage damage) const override;
  protocol::Answer to_unknown_command() const override { return {}; }

  std::uint16_t highest_id() const override { return 0xFF; }
  std::uint16_t highest_command() const override { return 0xFF; }
  std::span<const std::uint8_t> unknown_channels() const override;
  bool names_channel(const CommandRow& row) const override;
  protocol::Effect effect(const CommandRow& row) const override;
  using Dialect::effect;  // parameters have none
  std::vector<protocol::Bytes> before(const CommandRow& row, std::uint8_t channel) const override;
  std::vector<protocol::Bytes> after(const CommandRow& row, std::uint8_t channel) const override;
  /// The targets of speed and torque.
  bool moves(const ParameterRow& row) const override { return row.id == 0xE5 || row.id == 0xE6; }
  protocol::Range range(const ParameterRow& row) const override;
  std::vector<Need> needs(const ParameterRow& row) const override;
};

}  // namespace virtdrive::toshiba_mcu
