#include "shared/wire/command_message.h"

#include "shared/wire/fields.h"

namespace palpate {

void ToProto(const OperatorCommand& command, v1::OperatorCommand* message) {
  message->Clear();
  message->set_sequence(command.sequence);
  ToProto(command.sent_at, message->mutable_sent_at());
  message->set_epoch(command.epoch);
  ToProto(command.p_M, message->mutable_p_m());
  ToProto(command.velocity, message->mutable_velocity());
  message->set_engaged(command.engaged);
  message->set_energy_in(command.energy_in);
  message->set_energy_out(command.energy_out);
  message->set_state_sequence(command.state_sequence);
  if (command.echo) ToProto(*command.echo, message->mutable_echo());
}

std::optional<OperatorCommand> FromProto(const v1::OperatorCommand& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.sequence() > 0, "sequence = 0", "1 or more, rising");
  reader.Require(message.has_p_m() || !message.engaged(), "p_M is absent",
                 "a place while engaged is true");
  reader.Require(message.epoch() > 0 || !message.engaged(), "epoch = 0",
                 "1 or more while engaged is true");
  OperatorCommand command;
  command.sequence = message.sequence();
  if (message.has_sent_at()) command.sent_at = reader.Stamp("sent_at", message.sent_at());
  command.epoch = message.epoch();
  command.p_M = reader.Vector("p_M", message.p_m(), kMaxLength);
  command.velocity = reader.Vector("velocity", message.velocity(), kMaxSpeed);
  command.engaged = message.engaged();
  command.energy_in = reader.NonNegative("energy_in", message.energy_in(), kMaxEnergy);
  command.energy_out = reader.NonNegative("energy_out", message.energy_out(), kMaxEnergy);
  command.state_sequence = message.state_sequence();
  if (message.has_echo()) command.echo = reader.Stamp("echo", message.echo());
  if (!reader.ok()) return std::nullopt;
  return command;
}

}  // namespace palpate
