// What the table walk has to know of the MD protocol and of one model.
#pragma once

#include "devices/md485/model_table.h"
#include "devices/protocol/walk.h"

namespace virtdrive::md485 {

/// A walk's channel is the controller's ID. Left out: PID 133 and 149, after which the walk's own
/// requests would be heard differently.
class WalkDialect final : public protocol::Dialect {
 public:
  explicit WalkDialect(const ModelTable& table) : model_(table) {}

  const ProtocolTable& table() const override { return model_.table(); }
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
  protocol::Bytes resynchronise() const override { return {}; }

  std::optional<protocol::Answer> decode(std::span<const std::uint8_t> request,
                                         std::span<const std::uint8_t> reply) const override;
  std::optional<protocol::Setting> setting(const protocol::Values& reply) const override;

  protocol::Answer refusal(protocol::Refusal) const override { return {}; }
  protocol::Answer reaction(protocol::Damage) const override { return {}; }
  protocol::Answer written() const override { return {}; }
  std::optional<protocol::Setting> settles(const ParameterRow& row,
                                           protocol::Setting setting) const override;
  protocol::Answer to_unknown_command() const override { return {}; }

  std::uint16_t highest_id() const override { return 0xFF; }
  std::uint16_t highest_command() const override { return 0xFF; }
  std::span<const std::uint8_t> unknown_channels() const override;
  bool names_channel(const CommandRow&) const override { return false; }
  protocol::Effect effect(const CommandRow& row) const override;
  protocol::Effect effect(const ParameterRow& row) const override;
  /// Signs, references and what the terminals stand for: with the connector's inputs as they happen
  /// to be, the motor may turn.
  bool moves(const ParameterRow& row) const override;
  /// The default setting keeps a controller busy: nothing else may wait behind the last one.
  std::vector<protocol::Bytes> before(const CommandRow& row, std::uint8_t channel) const override;

 private:
  protocol::Values values_of(const ParameterRow& row, std::int64_t first) const;

  const ModelTable& model_;
};

}  // namespace virtdrive::md485
