// What the table walk must know of the RZ/T1 protocols. Variables and functions share one
// numbering; two walks put all of it to a board:
//
//   PacketDialect   packet types, functions by packet 2, variables by packets 5 and 6
//   LineDialect     functions and variables as lines of text
#pragma once

#include "devices/protocol/walk.h"
#include "devices/rzt1/table.h"

namespace virtdrive::rzt1 {

/// Axis 1, at its factory address.
class CommonDialect : public protocol::Dialect {
 public:
  std::span<const std::uint8_t> unknown_channels() const override { return {}; }
  bool names_channel(const CommandRow&) const override { return false; }
  std::optional<protocol::Setting> setting(const protocol::Values& reply) const override;
  std::uint16_t highest_id() const override { return 0xFF; }
  protocol::Effect effect(const CommandRow& row) const override;
  protocol::Effect effect(const ParameterRow& row) const override;
  bool moves(const ParameterRow& row) const override;
  std::vector<protocol::Bytes> before(const CommandRow& row, std::uint8_t channel) const override;
  std::vector<protocol::Bytes> after(const CommandRow& row, std::uint8_t channel) const override;
};

class PacketDialect final : public CommonDialect {
 public:
  /// The functions stand among the commands.
  const ProtocolTable& table() const override;
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
  protocol::Answer refusal(protocol::Refusal refusal) const override;
  protocol::Answer reaction(protocol::Damage damage) const override;
  protocol::Answer to_unknown_command() const override;
  std::uint16_t highest_command() const override { return 0xFF; }
  using CommonDialect::effect;
  protocol::Effect effect(const ParameterRow& row) const override;
};

class LineDialect final : public CommonDialect {
 public:
  const ProtocolTable& table() const override;
  std::optional<protocol::Values> sample(const CommandRow&, std::uint8_t) const override {
    return protocol::Values{};
  }
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
  protocol::Answer refusal(protocol::Refusal refusal) const override;
  protocol::Answer reaction(protocol::Damage damage) const override;
  protocol::Answer to_unknown_command() const override;
  std::uint16_t highest_command() const override { return 0; }
  using CommonDialect::effect;
  protocol::Effect effect(const ParameterRow& row) const override;
};

}  // namespace virtdrive::rzt1
