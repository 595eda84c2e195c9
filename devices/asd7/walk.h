// What the table walk has to know of the 7-Series' protocol: it asks in 32-bit binary, where every
// value has room.
#pragma once

#include "devices/asd7/table.h"
#include "devices/protocol/walk.h"

namespace virtdrive::asd7 {

/// A walk's channel does not count: requests have no number. Left out: what resets, trips or makes
/// the drive talk by itself.
class WalkDialect final : public protocol::Dialect {
 public:
  /// The rows of one size.
  explicit WalkDialect(const ProtocolTable& table) : table_(table) {}

  const ProtocolTable& table() const override { return table_; }
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

  std::uint16_t highest_id() const override { return 0x0200; }
  std::uint16_t highest_command() const override { return 0xFF; }
  std::span<const std::uint8_t> unknown_channels() const override { return {}; }
  bool names_channel(const CommandRow&) const override { return false; }
  using protocol::Dialect::effect;
  protocol::Effect effect(const ParameterRow& row) const override;
  /// Command and frequency words, and who gives them (CMOD, FMOD).
  bool moves(const ParameterRow& row) const override {
    return row.id >= 0xFA00 || row.id == 0x0003 || row.id == 0x0004;
  }
  protocol::Range range(const ParameterRow& row) const override;

 private:
  const ProtocolTable& table_;
};

}  // namespace virtdrive::asd7
