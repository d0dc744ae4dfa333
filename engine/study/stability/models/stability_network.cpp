#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>
#include <utility>

#include "engine/core/index.h"
#include "engine/study/stability/models/stability_graph.h"

namespace tactus {
namespace {

double depth_of(const Contact& contact, double push) {
  return std::pow(push / contact.stiffness, 1.0 / contact.exponent);
}

/// The same network with its closed contacts pressed in while everything that moves is at 0: its outputs are
/// then linearised at the indentation.
NetworkElements pressed(NetworkElements elements, const Touching& touching) {
  const auto place = [&](int point) {
    const auto& p = elements.points[index(point)];
    return p.kind == Point::Kind::Ground ? p.position : 0.0;
  };
  for (const int c : touching.contacts) {
    auto& contact = elements.contacts[index(c)];
    contact.offset = depth_of(contact, touching.push) - place(contact.lower) + place(contact.upper);
  }
  return elements;
}

Eigen::MatrixXd slopes(const Network& network, const NetworkElements& elements, const NetworkView& view,
                       std::size_t outputs, double size) {
  const auto above = unit_states(network, elements, size), below = unit_states(network, elements, -size);
  Eigen::MatrixXd slopes(static_cast<Eigen::Index>(outputs), static_cast<Eigen::Index>(above.size()));
  for (std::size_t o = 0; o < outputs; ++o)
    for (std::size_t i = 0; i < above.size(); ++i)
      slopes(static_cast<Eigen::Index>(o), static_cast<Eigen::Index>(i)) =
          (view.shown(network, above[i], static_cast<int>(o)) -
           view.shown(network, below[i], static_cast<int>(o))) /
          (2.0 * size);
  return slopes;
}

/// The first mass with a force or a coil that a signal reaches; -1: none.
int driven_point(const NetworkElements& elements) {
  const auto mass = [&](int point) { return elements.points[index(point)].kind == Point::Kind::Mass; };
  for (const auto& coil : elements.coils)
    if (coil.voltage.signal >= 0 && mass(coil.on)) return coil.on;
  // A hand's push is slow, a drive's is not.
  for (const bool slow : {false, true})
    for (const auto& force : elements.forces)
      if (force.input.signal >= 0 && force.input.bandwidth.has_value() == slow && mass(force.on))
        return force.on;
  return -1;
}

/// The modes of the matrices that were asked for last: what a control or a regime does not change is not
/// computed again.
std::vector<StepMode> remembered_modes(const Eigen::MatrixXd& a) {
  constexpr std::size_t kMost = 16;
  static std::mutex mutex;
  static std::deque<std::pair<Eigen::MatrixXd, std::vector<StepMode>>> last;
  {
    const std::lock_guard lock{mutex};
    for (const auto& [matrix, modes] : last)
      if (matrix.rows() == a.rows() && matrix == a) return modes;
  }
  auto found = modes(a);
  const std::lock_guard lock{mutex};
  last.emplace_front(a, found);
  if (last.size() > kMost) last.pop_back();
  return found;
}

}  // namespace

std::shared_ptr<const LinearNetwork> LinearNetwork::make(const NetworkView& view, const NodeType& type,
                                                         const Touching& touching,
                                                         const std::optional<Fingertip>& hand) {
  std::shared_ptr<LinearNetwork> model{new LinearNetwork};
  auto& recipe = model->recipe = view.recipe;
  model->written = recipe.elements;
  model->driven_ = driven_point(recipe.elements);
  if (model->driven_ >= 0) model->driven_row = static_cast<int>(type.outputs.size());
  for (std::size_t p = 0; p < recipe.elements.points.size(); ++p)
    if (recipe.elements.points[p].kind == Point::Kind::Mass) model->masses_.push_back(static_cast<int>(p));
  if (!recipe.elements.bonds.empty())
    for (std::size_t p = 0; p < recipe.elements.points.size(); ++p)
      recipe.elements.points[p].position = view.network.position(view.state, static_cast<int>(p));
  const double square_radius = type.turns ? kSquareRadius : 1;
  if (hand) model->add_fingertip({square_radius * hand->damping, square_radius * hand->mass});
  model->add_test_force();
  recipe.elements = tangent(std::move(recipe.elements), touching);
  const auto network =
      Network::make(recipe.elements, recipe.signals, recipe.rate, recipe.solver, recipe.oversample);
  if (!network) return nullptr;
  if (state_size(recipe.elements, recipe.signals) > kMostLinearised) {
    model->radius = radius_by_running(*network, recipe.elements, recipe.signals);
    return model;
  }
  const auto step = linear_step(*network, recipe.elements, recipe.signals);
  if (!step.a.allFinite() || !step.b.allFinite()) return nullptr;
  model->modes = remembered_modes(step.a);
  model->response_.emplace(step, model->readings(*network, view, type.outputs.size(), touching),
                           model->modes);
  if (!model->modes.empty()) model->radius = std::abs(model->modes.front().pole);
  return model;
}

void LinearNetwork::add_fingertip(const Fingertip& hand) {
  if (driven_ < 0) return;
  auto& elements = recipe.elements;
  elements.points[index(driven_)].mass += hand.mass;
  elements.points.push_back({.kind = Point::Kind::Ground, .input = {}});
  Spring grip{static_cast<int>(elements.points.size()) - 1, driven_};
  grip.damping = hand.damping;
  elements.springs.push_back(grip);
}

void LinearNetwork::add_test_force() {
  if (driven_ < 0) return;
  test_force = recipe.signals++;
  recipe.elements.forces.push_back({driven_, {test_force, {}}});
}

/// Most outputs are straight lines and are found to the last bit; those of closed contacts are not.
Eigen::MatrixXd LinearNetwork::readings(const Network& network, const NetworkView& view, std::size_t outputs,
                                        const Touching& touching) const {
  auto c = slopes(network, recipe.elements, view, outputs, 1.0);
  if (!touching.contacts.empty()) {
    double least = 1.0;
    for (const int i : touching.contacts)
      least = std::min(least, depth_of(recipe.elements.contacts[index(i)], touching.push));
    const auto pressed_elements = pressed(recipe.elements, touching);
    if (const auto pressed_network =
            Network::make(pressed_elements, recipe.signals, recipe.rate, recipe.solver, recipe.oversample)) {
      const auto bent = slopes(*pressed_network, pressed_elements, view, outputs, 1e-6 * least);
      for (Eigen::Index o = 0; o < c.rows(); ++o)
        if ((bent.row(o) - c.row(o)).norm() > 1e-3 * bent.row(o).norm()) c.row(o) = bent.row(o);
    }
  }
  if (driven_ < 0) return c;
  const auto slot = std::ranges::find(masses_, driven_) - masses_.begin();
  c.conservativeResize(c.rows() + 1, Eigen::NoChange);
  c.bottomRows(1).setZero();
  c(c.rows() - 1, slot) = 1.0;
  return c;
}

std::optional<Hertz> LinearNetwork::needed_rate() const {
  return least_rate(recipe.elements, recipe.signals, recipe.solver);
}

std::string LinearNetwork::carrier(const StepMode& mode) const {
  const auto moves = [&](int point) -> std::complex<double> {
    const auto at = std::ranges::find(masses_, point);
    return at == masses_.end() ? 0.0 : mode.shape[at - masses_.begin()];
  };
  int mass = -1, spring = -1;
  double most = 0.0, strained = 0.0;
  for (const int point : masses_)
    if (std::abs(moves(point)) > most) most = std::abs(moves(point)), mass = point;
  for (std::size_t s = 0; s < recipe.springs.size(); ++s) {
    const auto& link = recipe.elements.springs[s];
    const double stiffness = link.stiffness + 2.0 * link.damping * recipe.rate.value * recipe.oversample;
    const double strain = stiffness * std::norm(moves(link.lower) - moves(link.upper));
    if (strain > strained) strained = strain, spring = static_cast<int>(s);
  }
  if (mass < 0) return {};
  const auto& on = recipe.points[index(mass)];
  return spring < 0 || recipe.springs[index(spring)].empty() ? on
                                                             : on + " on " + recipe.springs[index(spring)];
}

std::string LinearNetwork::weakest() const {
  if (!whole()) return {};
  if (grows()) return carrier(modes.front());
  const auto needed = needed_rate();
  if (!needed || !std::isfinite(needed->value)) return {};
  const auto network = Network::make(recipe.elements, recipe.signals, *needed * 0.98, recipe.solver, 1);
  if (!network) return {};
  const auto broken = tactus::modes(linear_step(*network, recipe.elements, recipe.signals).a);
  return broken.empty() ? std::string{} : carrier(broken.front());
}

}  // namespace tactus
