// How parts with a rate of their own run: in each stretch of engine frames those of their frames that lie in
// it.
#include <algorithm>

#include "engine/runtime/engine.h"

namespace tactus {

/// The fault, if there is one, counts in engine frames.
Engine::Fault Engine::run_paced(const Step& step, bool loop, int offset, int frames) noexcept {
  const Pace* const at = pace(step.pace);
  const int first = at == nullptr ? offset : at->count(offset);
  const int count = at == nullptr ? frames : at->count(offset + frames) - first;
  if (count == 0) return {};
  Fault fault;
  if (step.kind == Step::Kind::Operations) {
    fault = run_operations(step, loop, first, count);
  } else {
    NodeBlock block{plan_->inputs.data() + step.first_in, plan_->outputs.data() + step.first_out,
                    count, at == nullptr ? now_ + offset : at->number + first};
    move_paced(step, at == nullptr ? offset : at->place(first), block);
    fault = run_node(step, block);
  }
  if (fault.vertex != kSound && at != nullptr) fault.frame = at->place(first + fault.frame) - offset;
  return fault;
}

/// What a step reads and writes, each at its own rate, from `offset` into the piece on. Of what is faster
/// than itself it reads only the frames that are its own.
void Engine::move_paced(const Step& step, int offset, NodeBlock& block) noexcept {
  const auto& every = plan_->paces;
  const int own = every[static_cast<std::size_t>(step.pace)];
  const int apart = std::max(1, own / every[static_cast<std::size_t>(step.pace_in)]);
  const Pace *const in = pace(step.pace_in), *const out = pace(step.pace_out);
  const int from = in == nullptr ? offset : in->count(offset);
  const int to = out == nullptr ? offset : out->count(offset);
  for (int i = 0; i < step.inputs; ++i)
    running_->moved_in[static_cast<std::size_t>(i)] = {block.in[i].data + from * block.in[i].stride,
                                                       apart * block.in[i].stride};
  for (int i = 0; i < step.outputs; ++i)
    running_->moved_out[static_cast<std::size_t>(i)] =
        block.out[i] == nullptr ? nullptr : block.out[i] + to * step.width;
  block.in = running_->moved_in.data();
  block.out = running_->moved_out.data();
}

}  // namespace tactus
