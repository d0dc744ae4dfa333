#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "engine/core/index.h"
#include "engine/core/realtime.h"
#include "engine/nodes/networks/network.h"
#include "engine/physics/low_pass_kernel.h"
#include "engine/physics/solvers/solver_tables.h"
#include "export/kernel_texts.h"
#include "export/kernels/coupling_kernel.h"
#include "export/kernels/friction_kernel.h"
#include "export/networks/network_text.h"
#include "export/nodes/table.h"

namespace tactus {
namespace {

using Numbers = std::vector<double>;
using Integers = std::vector<int>;

std::string number_text(int value) { return std::to_string(value); }
std::string number_text(double value) {
  const auto text = NodeWriter::number(value);
  return value < 0.0 ? "(" + text + ")" : text;
}

bool all_same(const auto& list) {
  return std::ranges::all_of(list, [&](auto value) { return value == list.front(); });
}
bool all_zero(const auto& list) {
  return std::ranges::all_of(list, [](auto value) { return value == 0; });
}

template <class List, class Of>
auto list_of(const List& list, Of of) {
  std::vector<decltype(of(list.front()))> values;
  for (const auto& item : list) values.push_back(of(item));
  return values;
}

/// Writes the functions that step a network: those of export/networks, as far as it needs them, with its own
/// names, tables and state.
class NetworkWriter {
 public:
  NetworkWriter(NodeWriter& node, const NetworkView& view)
      : node_(node),
        network_(view.network),
        model_(network_.model()),
        tables_(network_.network_solver().tables()),
        couplings_(*tables_.couplings),
        view_(view) {
    const NoDenormals none;  // as the engine starts it
    start_ = network_.initial_state();
  }

  void write() {
    find_values();
    find_flags();
    add_constants();
    add_model();
    add_couplings();
    if (exact())
      add_groups();
    else
      add_centred();
    add_members();
    write_functions();
    write_start();
    std::string signals;
    for (const int port : view_.recipe.signal_ports)
      signals += (signals.empty() ? "" : ", ") + node_.in(port);
    const auto step = names_.at("net_step");
    node_.late(signals.empty() ? step + "(s, 0);" : step + "(s, (const tactus_real[]){" + signals + "});");
    for (std::size_t i = 0; i < values_.size(); ++i)
      if (!values_[i].empty()) node_.give(static_cast<int>(i), with_names(values_[i]));
  }

 private:
  bool exact() const { return network_.solver() == Solver::Exact; }
  bool factored() const {
    return network_.solver() == Solver::Passive || network_.solver() == Solver::Implicit;
  }
  int slots() const { return static_cast<int>(model_.start_position.size()); }
  int moving() const { return model_.masses + static_cast<int>(model_.motions.size()); }
  int roots() const { return static_cast<int>(model_.contacts.size() + model_.bonds.size()); }
  bool is(const char* flag) const { return flags_.find(flag)->second; }

  // What is read, as C text.

  std::string position(int slot) const { return "s->net_position[" + number_text(slot) + "]"; }
  std::string velocity(int slot) const { return "net_velocity(s, " + number_text(slot) + ")"; }
  /// The difference of two ends along a spring's direction; `at` a slot.
  template <class At>
  std::string span_of(const Spring& spring, At at) const {
    if (spring.axes == 1) return at(spring.upper) + " - " + at(spring.lower);
    std::string sum;
    for (int a = 0; a < spring.axes; ++a)
      sum += (a > 0 ? " + " : "") + number_text(spring.along[index(a)]) + " * (" + at(spring.upper + a) +
             " - " + at(spring.lower + a) + ")";
    return sum;
  }
  std::string extension(int number) const {
    const auto& spring = model_.springs[index(number)];
    return "(" + span_of(spring, [&](int slot) { return position(slot); }) + " - " +
           number_text(spring.rest) + ")";
  }
  std::string spring_force(int number) const {
    const auto& spring = model_.springs[index(number)];
    const auto pull = number_text(spring.stiffness) + " * " + extension(number);
    // Without a stiffness the other product may decide the sign of a zero.
    if (spring.damping == 0.0 && spring.stiffness != 0.0) return "(" + pull + ")";
    return "(" + pull + " + " + number_text(spring.damping) + " * (" +
           span_of(spring, [&](int slot) { return velocity(slot); }) + "))";
  }
  std::string applied_force(int number) const {
    const auto& input = model_.forces[index(number)].input;
    return input.low_pass >= 0 ? "s->net_low_pass[" + number_text(input.low_pass) + "].value" : held(input);
  }
  static std::string held(const NetworkInput& input) {
    return "s->net_held[" + number_text(input.signal) + "]";
  }

  /// As `Network` reads it.
  std::string value_of(const ReadElement::Term& term, int part) const {
    const auto is = [&](auto read) { return term.value == read; };
    const auto item = [part](const char* member) {
      return std::string{"s->net_"} + member + "[" + number_text(part) + "]";
    };
    const auto call = [part](const char* function) {
      return std::string{"net_"} + function + "(s, " + number_text(part) + ")";
    };
    if (is(&Network::position)) return position(model_.slot[index(part)]);
    if (is(&Network::velocity)) return velocity(model_.slot[index(part)]);
    if (is(&Network::extension)) return extension(part);
    if (is(&Network::spring_force)) return spring_force(part);
    if (is(&Network::indentation)) return "tactus_max(0.0, " + call("indentation") + ")";
    if (is(&Network::contact_force)) return call("contact_force");
    if (is(&Network::applied_force)) return applied_force(part);
    if (is(&Network::current)) return call("current_of");
    if (is(&Network::coil_force))
      return "(" + number_text(model_.coils[index(part)].force_factor) + " * " + call("current_of") + ")";
    if (is(&Network::friction_force)) return item("friction_force");
    if (is(&Network::friction_velocity)) return item("friction_velocity");
    if (is(&Network::bond_force)) return call("bond_force");
    if (is(&Network::bond_distance)) return call("stretch");
    if (is(&Network::wave)) return item("wave_back");
    if (is(&Network::port_force)) return "(" + item("wave") + " + " + item("wave_back") + ")";
    throw std::logic_error("a quantity of a network that no program reads");
  }

  void find_values() {
    for (std::size_t i = 0; i < view_.readings.size(); ++i) {
      auto& text = values_.emplace_back();
      if (!node_.reads(static_cast<int>(i))) continue;
      const auto& [read, parts] = view_.readings[i];
      if (i + 1 == view_.readings.size()) text = "net_energy(s)";
      for (const auto& term : read.terms)
        if (const int part = parts.*term.part; part >= 0)
          text += (term.negative ? (text.empty() ? "-" : " - ") : (text.empty() ? "" : " + ")) +
                  value_of(term, part + term.axis);
      if (text.empty()) text = "0.0";
    }
  }
  bool any_value_has(std::initializer_list<const char*> names) const {
    return std::ranges::any_of(names, [&](const char* name) {
      return presses().find(name) != std::string::npos ||
             std::ranges::any_of(values_,
                                 [&](const std::string& text) { return text.find(name) != text.npos; });
    });
  }

  /// What presses each friction (Network::press).
  std::string presses() const {
    std::string text;
    for (std::size_t f = 0; f < model_.frictions.size(); ++f) {
      const auto& friction = model_.frictions[f];
      const auto number = number_text(static_cast<int>(f)), signal = number_text(friction.normal.signal);
      text += "  s->net_normal[" + number + "] = ";
      if (friction.normal_contact >= 0)
        text += "net_contact_force(s, " + number_text(friction.normal_contact) + ")";
      else if (friction.normal_spring >= 0)
        text += spring_force(friction.normal_spring);
      else  // what is pressed has been pressed before the start
        text += "s->net_friction[" + number + "].margin == -2 ? in[" + signal + "] : net_enter(s, in, " +
                signal + ", part)";
      text += ";\n";
    }
    return text;
  }

  // What there is.

  void find_flags() {
    const auto& m = model_;
    const auto solver = network_.solver();
    const auto any = [](const auto& list, auto meets) { return std::ranges::any_of(list, meets); };
    const auto power = [&](double exponent) {
      return any(m.contacts, [=](const auto& c) { return c.exponent == exponent; });
    };
    const auto filtered = [](const AppliedForce& force) { return force.input.low_pass >= 0; };
    const bool odd_power = any(m.contacts, [](const auto& c) {
      return c.exponent != 1.0 && c.exponent != 1.5 && c.exponent != 2.0 && c.exponent != 3.0;
    });
    const auto set = [&](const char* flag, bool on) { flags_[flag] = on; };
    set("EXPLICIT", solver == Solver::Explicit);
    set("PASSIVE", solver == Solver::Passive);
    set("IMPLICIT", solver == Solver::Implicit);
    set("EXACT", exact());
    set("CENTRED", !exact());
    set("FACTORED", factored());
    set("AVERAGED", tables_.averaged);
    set("QUADRATISED", exact() || solver == Solver::Passive);
    set("MASSES", m.masses > 0);
    set("MOTIONS", !m.motions.empty());
    set("FORCES", !m.forces.empty());
    set("COILS", !m.coils.empty());
    set("PORTS", !m.ports.empty());
    set("CONTACTS", !m.contacts.empty());
    set("BONDS", !m.bonds.empty());
    set("FRICTIONS", !m.frictions.empty());
    set("SPRINGS", !m.springs.empty());
    set("LEANING", any(m.springs, [](const Spring& s) { return s.axes > 1; }));
    set("LENGTHS", !m.springs.empty());
    set("COUPLINGS", !couplings_.empty());
    set("ROOTS", roots() > 0);
    set("SOLVED", solver != Solver::Explicit && roots() > 0);
    set("LINES", m.has_lines());
    set("ALONE", couplings_.alone());
    set("LOSSES", any(m.contacts, [](const auto& c) { return c.loss > 0.0 || c.loss_speed > 0.0; }));
    set("RESTITUTION", any(m.contacts, [](const auto& c) { return c.loss_speed > 0.0; }));
    set("POWER_ZERO", power(1.0));
    set("POWER_QUARTER", power(1.5));
    set("POWER_HALF", power(2.0));
    set("POWER_ONE", power(3.0));
    set("POWER_ANY", odd_power);
    set("ONE_POWER", power(1.0) + power(1.5) + power(2.0) + power(3.0) + odd_power == 1);
    set("WELLS", any(m.bonds, [](const Bond& b) { return !b.law->linear(); }));
    set("SPRING_BONDS", any(m.bonds, [](const Bond& b) { return b.law->linear(); }));
    set("BENDS", any(m.bonds, [](const Bond& b) { return b.axes > 1 || !b.law->linear(); }));
    set("LIMITS", any(m.bonds, &Bond::slips));
    set("BOND_INERTIA", has_bond_inertia());
    set("LOW_PASSES", !m.low_passes.empty());
    set("MOTION_LOW_PASSES", any(m.motions, filtered));
    set("FORCE_LOW_PASSES", any(m.forces, filtered));
    set("OVERSAMPLED", network_.oversample() > 1);
    set("GROUPS", !tables_.groups.empty());
    set("HELD_CURRENTS", exact() && any(m.coils, [](const auto& c) { return c.inductance > 0.0; }));
    set("ROW", tables_.row != nullptr);
    set("JUMPS", tables_.jumps != nullptr && !tables_.jumps->entries().empty());
    set("DRIVEN", !tables_.driven.empty());
    set("ADVANCES", moving() > (tables_.row != nullptr ? m.masses : 0));
    set("SETTLES", settles());
    set("WAVES", any_value_has({"net_wave_back"}));
    set("VELOCITIES",
        !exact() && any_value_has({"net_velocity", "net_current_of", "net_contact_force", "net_bond_force"}));
    const bool entered =
        !exact() && (!m.coils.empty() || any(m.forces, std::not_fn(filtered)) ||
                     any(m.frictions, [](const Friction& f) { return f.normal.signal >= 0; }));
    const bool moved = network_.oversample() > 1 && any(m.motions, std::not_fn(filtered));
    set("HELD", entered || moved || any_value_has({"net_held"}));
  }

  bool has_bond_inertia() const {
    if (!factored()) return false;
    for (std::size_t b = 0; b < model_.bonds.size(); ++b)
      if (couplings_.inertia(b) > 0.0) return true;
    return false;
  }

  /// Whether the first inputs decide where it starts, or bonds slip at once.
  bool settles() const {
    if (!model_.motions.empty() || !model_.low_passes.empty()) return true;
    return std::ranges::any_of(model_.bonds, [&](const Bond& bond) {
      return std::abs(bond.law->force(stretch(start_.position, bond))) > bond.limit;
    });
  }

  // Names and numbers.

  void constant(const std::string& name, int value) { constants_["NET_" + name] = number_text(value); }
  void constant(const std::string& name, double value) { constants_["NET_" + name] = number_text(value); }
  void table(const std::string& name, Numbers values) { numbers_["net_" + name] = std::move(values); }
  void table(const std::string& name, Integers values) { integers_["net_" + name] = std::move(values); }

  void add_constants() {
    constant("MASSES", model_.masses);
    constant("MOTIONS", static_cast<int>(model_.motions.size()));
    constant("MOVING", moving());
    constant("SLOTS", slots());
    constant("FORCES", static_cast<int>(model_.forces.size()));
    constant("COILS", static_cast<int>(model_.coils.size()));
    constant("PORTS", static_cast<int>(model_.ports.size()));
    constant("SPRINGS", static_cast<int>(model_.springs.size()));
    constant("CONTACTS", static_cast<int>(model_.contacts.size()));
    constant("BONDS", static_cast<int>(model_.bonds.size()));
    constant("FRICTIONS", static_cast<int>(model_.frictions.size()));
    constant("FIRST_FRICTION", roots());
    constant("ROOTS", roots());
    constant("LOW_PASSES", static_cast<int>(model_.low_passes.size()));
    constant("SIGNALS", model_.signals);
    constant("PARTS", network_.oversample());
    constant("STEP", model_.k);
    constant("STEPS", exact() ? 1 : 2);
    constant("SLACK", (exact() ? 1 : 2) * model_.k);
    constant("ROW_END", tables_.row != nullptr ? model_.masses : 0);
  }

  void add_inputs(const std::string& name, const auto& list, const auto& input_of) {
    table(name + "_signal", list_of(list, [&](const auto& one) { return input_of(one).signal; }));
    table(name + "_low_pass", list_of(list, [&](const auto& one) { return input_of(one).low_pass; }));
  }

  void add_model() {
    const auto& m = model_;
    const auto input = [](const AppliedForce& force) -> const NetworkInput& { return force.input; };
    table("mass", m.mass);
    table("scale", m.scale);
    table("first_velocity", m.start_velocity);
    table("start_velocity",
          exact() ? m.start_velocity : Numbers(tables_.start_velocity.begin(), tables_.start_velocity.end()));
    add_inputs("motion", m.motions, input);
    add_inputs("force", m.forces, input);
    add_inputs("coil", m.coils, [](const auto& coil) -> const NetworkInput& { return coil.voltage; });
    add_inputs("port", m.ports, [](const WavePort& port) -> const NetworkInput& { return port.wave; });
    table("force_on", list_of(m.forces, [](const AppliedForce& force) { return force.on; }));
    table("port_on", list_of(m.ports, [](const WavePort& port) { return port.on; }));
    table("port_impedance", list_of(m.ports, [](const WavePort& port) { return port.impedance; }));
    table("coil_on", list_of(m.coils, [](const auto& coil) { return coil.on; }));
    table("coil_against", list_of(m.coils, [](const auto& coil) { return coil.against; }));
    table("coil_factor", list_of(m.coils, [](const auto& coil) { return coil.force_factor; }));
    table("coil_resistance", list_of(m.coils, [](const auto& coil) { return coil.resistance; }));
    table("coil_inductance", list_of(m.coils, [](const auto& coil) { return coil.inductance; }));
    table("coil_memory", list_of(m.coils, [](const auto& coil) { return coil.memory; }));
    table("coil_impedance", list_of(m.coils, [](const auto& coil) { return coil.impedance; }));
    table("coil_decay", list_of(m.coils, [](const auto& coil) { return coil.half_step_decay; }));
    table("spring_lower", list_of(m.springs, [](const Spring& s) { return s.lower; }));
    table("spring_upper", list_of(m.springs, [](const Spring& s) { return s.upper; }));
    table("spring_axes", list_of(m.springs, [](const Spring& s) { return s.axes; }));
    table("spring_rest", list_of(m.springs, [](const Spring& s) { return s.rest; }));
    table("spring_stiffness", list_of(m.springs, [](const Spring& s) { return s.stiffness; }));
    Numbers along;
    for (const auto& spring : m.springs) along.insert(along.end(), spring.along.begin(), spring.along.end());
    table("spring_along", along);
    table("pole", list_of(m.low_passes, [](const CriticalLowPass& filter) { return filter.pole(); }));
    table("decay", list_of(m.low_passes, [](const CriticalLowPass& filter) { return filter.decay(); }));
    Integers signals(m.low_passes.size());
    for (const auto* list : {&m.motions, &m.forces})
      for (const auto& one : *list)
        if (one.input.low_pass >= 0) signals[index(one.input.low_pass)] = one.input.signal;
    table("low_pass_signal", signals);
  }

  void add_couplings() {
    const auto& m = model_;
    Integers lower, upper, axes;
    Numbers offset;
    const auto add = [&](const auto& list) {
      for (const auto& link : list) {
        lower.push_back(link.lower), upper.push_back(link.upper);
        axes.push_back(1), offset.push_back(0.0);
        if constexpr (requires { link.axes; }) axes.back() = link.axes;
        if constexpr (requires { link.offset; }) offset.back() = link.offset;
      }
    };
    add(m.contacts), add(m.bonds), add(m.frictions);
    table("lower", lower), table("upper", upper), table("axes", axes), table("offset", offset);
    table("row", list_of(couplings_.rows(), [](std::size_t row) { return static_cast<int>(row); }));
    table("mutual", Numbers(couplings_.mutual().begin(), couplings_.mutual().end()));
    table("column", Numbers(couplings_.columns().begin(), couplings_.columns().end()));
    constant("ROWS", static_cast<int>(couplings_.row_count()));
    constant("FIRST_ROW", static_cast<int>(couplings_.first_row()));
    add_contacts();
    add_bonds();
    add_frictions();
  }

  /// As `ContactLaw`.
  void add_contacts() {
    const auto& contacts = model_.contacts;
    table("law_slope",
          list_of(contacts, [](const auto& c) { return std::sqrt(0.5 * c.stiffness * (c.exponent + 1.0)); }));
    table("law_share", list_of(contacts, [](const auto& c) { return 2.0 / (c.exponent + 1.0); }));
    table("law_half_power", list_of(contacts, [](const auto& c) { return 0.5 * (c.exponent - 1.0); }));
    table("law_power", list_of(contacts, [](const auto& c) {
            return c.exponent == 1.0   ? 0
                   : c.exponent == 1.5 ? 1
                   : c.exponent == 2.0 ? 2
                   : c.exponent == 3.0 ? 3
                                       : 4;
          }));
    constants_["NET_RAISED"] = is("POWER_ZERO")      ? "1"
                               : is("POWER_QUARTER") ? "sqrt(sqrt(n))"
                               : is("POWER_HALF")    ? "sqrt(n)"
                               : is("POWER_ONE")     ? "n"
                                                     : "pow(n, net_law_half_power[c])";
    table("loss_speed", list_of(contacts, [](const auto& c) { return c.loss_speed; }));
    table("own_loss", list_of(contacts, [](const auto& c) { return c.loss; }));
  }

  void add_bonds() {
    const auto& bonds = model_.bonds;
    table("bond_slope",
          list_of(bonds, [](const Bond& b) { return b.law->linear() ? b.law->root_slope(0.0) : 0.0; }));
    table("bond_stiffness", list_of(bonds, [](const Bond& b) { return b.law->stiffness(0.0); }));
    table("bond_damping", list_of(bonds, [](const Bond& b) { return b.damping; }));
    table("bond_rest", list_of(bonds, [](const Bond& b) { return b.rest; }));
    table("bond_limit", list_of(bonds, [](const Bond& b) { return b.limit; }));
    table("bond_bends", list_of(bonds, [](const Bond& b) { return b.axes > 1 || !b.law->linear() ? 1 : 0; }));
    Numbers inertia;
    for (std::size_t b = 0; b < bonds.size(); ++b) inertia.push_back(couplings_.inertia(b));
    table("bond_inertia", inertia);
    std::string wells;
    for (const auto& bond : bonds) {
      const auto well = bond.law->well();
      wells += (wells.empty() ? "{" : ", {") + NodeWriter::number(well.length) + ", " +
               NodeWriter::number(well.depth) + "}";
    }
    structs_["net_bond_well"] = {"tactus_well", wells, sizeof(tactus_well) * bonds.size()};
  }

  void add_frictions() {
    std::string laws;
    Numbers speeds;
    for (const auto& f : model_.frictions) {
      const auto pair = [](double one, double other) {
        return "{" + NodeWriter::number(one) + ", " + NodeWriter::number(other) + "}";
      };
      const auto& [one, other] = f.law.drops;
      laws += (laws.empty() ? "{" : ", {") + NodeWriter::number(f.law.kinetic) + ", " +
              pair(one.size, other.size) + ", " + pair(one.speed, other.speed) + ", " +
              NodeWriter::number(f.viscous) + "}";
      speeds.push_back(between(model_.start_velocity, f));
    }
    structs_["net_friction_law"] = {"tactus_friction_law", laws,
                                    sizeof(tactus_friction_law) * model_.frictions.size()};
    table("friction_speed", speeds);
    table("lightness", [&] {
      Numbers lightness(index(slots()));
      for (int i = 0; i < model_.masses; ++i) lightness[index(i)] = 1.0 / model_.mass[index(i)];
      return lightness;
    }());
  }

  void add_groups() {
    Integers mass, input, coil, masses, states, columns, first, mass_group, mass_unit, mass_way, mass_flow;
    Numbers matrix, constants, unit;
    for (auto* list : {&mass_group, &mass_unit, &mass_way, &mass_flow}) list->resize(index(model_.masses));
    for (const auto& group : tables_.groups) {
      const int count = static_cast<int>(group.masses.size()), at = static_cast<int>(constants.size());
      const int all = 2 * count + static_cast<int>(group.coils.size());
      for (int i = 0; i < count; ++i) {
        const auto slot = index(group.masses[index(i)]);
        mass_group[slot] = static_cast<int>(masses.size());
        mass_unit[slot] = static_cast<int>(unit.size()) + i * all;
        mass_flow[slot] = at + i, mass_way[slot] = at + count + i;
      }
      mass.insert(mass.end(), group.masses.begin(), group.masses.end());
      coil.insert(coil.end(), group.coils.begin(), group.coils.end());
      for (const auto& [kind, of] : group.inputs) input.insert(input.end(), {static_cast<int>(kind), of});
      masses.push_back(count), states.push_back(all), first.push_back(at);
      columns.push_back(all + static_cast<int>(group.inputs.size()));
      matrix.insert(matrix.end(), group.step.begin(), group.step.end());
      constants.insert(constants.end(), group.constant.begin(), group.constant.end());
      unit.insert(unit.end(), group.unit.begin(), group.unit.end());
    }
    table("group_mass", mass), table("group_input", input), table("group_coil", coil);
    table("group_masses", masses), table("group_states", states), table("group_columns", columns);
    table("group_first", first), table("group_matrix", matrix), table("group_constant", constants);
    table("unit_push", unit), table("mass_group", mass_group), table("mass_unit", mass_unit);
    table("mass_way", mass_way), table("mass_flow", mass_flow);
    constant("GROUPS", static_cast<int>(tables_.groups.size()));
    // Eigen's product of a matrix and a vector takes so many columns at a time, where it takes 128 or more.
    constant("TOGETHER", 16);
    member("entering", columns.empty() ? 0 : *std::ranges::max_element(columns));
    member("flow_to", static_cast<int>(constants.size()));
  }

  void add_centred() {
    add_links("link", *tables_.links);
    if (is("JUMPS")) add_links("jump", *tables_.jumps);
    table("driven_mass", list_of(tables_.driven, [](const auto& c) { return c.mass; }));
    table("driven_by", list_of(tables_.driven, [](const auto& c) { return c.driven; }));
    table("driven_a", list_of(tables_.driven, [](const auto& c) { return c.a; }));
    constant("DRIVEN", static_cast<int>(tables_.driven.size()));
    if (tables_.row != nullptr) add_row(tables_.row->numbers());
    if (!factored()) return;
    add_solver("solve", *tables_.solver);
    if (tables_.start_solver != tables_.solver) add_solver("start_solve", *tables_.start_solver);
  }

  void add_row(const MassRow::Masses& row) {
    // To the next one, which the last does not have.
    table("row_k", Numbers(row.k.begin(), row.k.end() - 1));
    table("row_b", Numbers(row.b.begin(), row.b.end() - 1));
    table("row_own_k", row.own_k), table("row_own_b", row.own_b);
    table("row_scale", row.scale);
    Integers first, last, pushed;
    for (int i = 0; i + 1 < model_.masses; ++i) {  // the last one is always pushed
      if (i == 0 || row.pushed[index(i)] != row.pushed[index(i - 1)])
        first.push_back(i), last.push_back(i), pushed.push_back(row.pushed[index(i)] ? 1 : 0);
      ++last.back();
    }
    constant("RUNS", static_cast<int>(first.size()));
    table("run_first", first), table("run_last", last), table("run_pushed", pushed);
  }

  /// The function "net_links" of an operator, with tables that begin with its name.
  void add_links(const std::string& name, const LinkOperator& links) {
    const auto sums = links.sums();
    auto flags = flags_;
    flags["CHAIN"] = sums.chain, flags["BELOW_FIRST"] = sums.below_first;
    flags["FUSED"] = !sums.fused.empty(), flags["PLAIN"] = !sums.plain.empty();
    const auto begin = "net_" + name;
    text_ += renamed(chosen_lines(network_file("/links.c.in"), flags),
                     {{"net_link", begin}, {"NET_LINK", name == "link" ? "NET_LINK" : "NET_JUMP"}});
    const auto column = [](const LinkOperator::Entry& e) { return e.column; };
    const auto k = [](const LinkOperator::Entry& e) { return e.k; };
    const auto b = [](const LinkOperator::Entry& e) { return e.b; };
    table(name + "_constant", sums.constant);
    table(name + "_own_k", sums.own_k), table(name + "_own_b", sums.own_b);
    table(name + "_next_k", sums.next_k), table(name + "_next_b", sums.next_b);
    Integers begins(index(model_.masses + 1));
    for (const auto& entry : sums.fused) ++begins[index(entry.row + 1)];
    for (std::size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
    table(name + "_fused_begin", begins), table(name + "_fused_column", list_of(sums.fused, column));
    table(name + "_fused_k", list_of(sums.fused, k)), table(name + "_fused_b", list_of(sums.fused, b));
    table(name + "_plain_row", list_of(sums.plain, [](const LinkOperator::Entry& e) { return e.row; }));
    table(name + "_plain_column", list_of(sums.plain, column));
    table(name + "_plain_k", list_of(sums.plain, k)), table(name + "_plain_b", list_of(sums.plain, b));
    constant(in_capitals(name) + "_PLAIN", static_cast<int>(sums.plain.size()));
  }

  static std::string in_capitals(std::string text) {
    for (auto& c : text) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    return text;
  }

  void add_solver(const std::string& name, const SparseSolver& solver) {
    auto flags = flags_;
    flags["SOLVE_DIAGONAL"] = solver.diagonal(), flags["SOLVE_CHAIN"] = !solver.below().empty();
    const bool sweeps = !solver.diagonal() && solver.below().empty();
    flags["SOLVE_SWEEPS"] = sweeps;
    const std::map<std::string, std::string> names = {{"net_solve", "net_" + name},
                                                      {"NET_SOLVE", "NET_" + in_capitals(name)}};
    table(name + "_inverse", solver.inverse()), table(name + "_below", solver.below());
    table(name + "_row", solver.rows()), table(name + "_slot", solver.slots());
    constant(in_capitals(name) + "_SLOTS", static_cast<int>(solver.workspace()));
    if (sweeps)
      add_sweep(name + "_forward", solver.forward()), add_sweep(name + "_backward", solver.backward());
    text_ += renamed(chosen_lines(network_file("/solve.c.in"), flags), names);
  }

  void add_sweep(const std::string& name, const TriangularSweep& sweep) {
    Integers eight, columns, slot, begin;
    auto run = sweep.runs().begin();
    for (std::size_t i = 0; i < sweep.sums().size(); ++i) {
      while (i == run->end) ++run;
      const auto& sum = sweep.sums()[i];
      eight.push_back(run->in_lanes ? 1 : 0), columns.push_back(sum.columns), slot.push_back(sum.slot);
      begin.push_back(static_cast<int>(sum.values));
    }
    auto flags = flags_;
    flags["SWEEP_EIGHT"] = !all_zero(eight);
    flags["SWEEP_ONE"] = !std::ranges::all_of(eight, [](int one) { return one == 1; });
    text_ += renamed(chosen_lines(network_file("/sweep.c.in"), flags),
                     {{"net_sweep", "net_" + name}, {"NET_SWEEP", "NET_" + in_capitals(name)}});
    table(name + "_eight", eight), table(name + "_columns", columns), table(name + "_slot", slot);
    table(name + "_begin", begin), table(name + "_slots", sweep.slots());
    table(name + "_values", Numbers(sweep.values().begin(), sweep.values().end()));
    constant(in_capitals(name) + "_SUMS", static_cast<int>(eight.size()));
  }

  // The state.

  struct Member {
    std::string type = "tactus_real";
    int count = 0;  ///< 0: no array
    std::size_t bytes = sizeof(double);
  };
  void member(const std::string& name, int count) {
    members_["net_" + name] = {"tactus_real", std::max(1, count), sizeof(double)};
  }
  template <class Type>
  void member(const std::string& name, const std::string& type, std::size_t count) {
    members_["net_" + name] = {type, std::max(1, static_cast<int>(count)), sizeof(Type)};
  }

  void add_members() {
    const auto& m = model_;
    for (const char* name : {"position", "moved", "moved_before", "speed", "change"}) member(name, slots());
    const int frictions = static_cast<int>(m.frictions.size()), coils = static_cast<int>(m.coils.size());
    for (const char* name : {"friction_force", "friction_velocity", "normal", "sliding"})
      member(name, frictions);
    for (const char* name : {"current", "mean_current", "voltage"}) member(name, coils);
    for (const char* name : {"wave", "wave_back"}) member(name, static_cast<int>(m.ports.size()));
    member("force", static_cast<int>(m.forces.size()));
    member("next", static_cast<int>(m.motions.size()));
    member("held", m.signals);
    member("root", roots()), member("right", roots()), member("matrix", roots() * roots());
    member("loss", static_cast<int>(m.contacts.size()));
    member("slipped", static_cast<int>(m.bonds.size()));
    member("along", 3 * static_cast<int>(m.bonds.size()));
    member("row_force", static_cast<int>(couplings_.row_count()));
    member("row_motion", static_cast<int>(couplings_.row_count()));
    member<tactus_coupling>("active", "tactus_coupling", index(roots()));
    member<tactus_friction_memory>("friction", "tactus_friction_memory", m.frictions.size());
    member<tactus_friction_force>("rubbed", "tactus_friction_force", m.frictions.size());
    member<tactus_critical_low_pass>("low_pass", "tactus_critical_low_pass", m.low_passes.size());
    members_["net_active_count"] = members_["net_settled"] = {"int", 0, sizeof(int)};
    if (factored())
      member("work",
             static_cast<int>(std::max(tables_.solver->workspace(), tables_.start_solver->workspace())));
  }

  /// Where the network is before its first frame.
  void write_start() {
    const auto set = [&](const char* name, const auto& values) {
      const auto found = used_members_.find(std::string{"net_"} + name);
      if (found == used_members_.end() || values.empty() || all_zero(values)) return;
      const Numbers list(values.begin(), values.end());
      const auto count = std::to_string(list.size());
      const auto value = all_same(list) ? NodeWriter::number(list.front())
                                        : node_.table("start_" + std::string{name}, list) + "[k]";
      node_.start("for (int k = 0; k < " + count + "; ++k) " + found->second + "[k] = " + value + ";");
    };
    set("position", start_.position);
    set("moved", start_.moved);
    set("moved_before", start_.moved_before);
    set("speed", start_.velocity);
    set("root", start_.root);
    set("loss", start_.loss);
    set("sliding", start_.sliding);
    if (const auto found = used_members_.find("net_friction"); found != used_members_.end())
      for (std::size_t f = 0; f < start_.friction.size(); ++f) {
        const auto memory = found->second + "[" + std::to_string(f) + "]";
        node_.start(memory + ".margin = " + NodeWriter::number(start_.friction[f].margin) + ";");
        if (start_.friction[f].heat != 0.0)
          node_.start(memory + ".heat = " + NodeWriter::number(start_.friction[f].heat) + ";");
      }
  }

  // The functions.

  void write_functions() {
    if (exact()) text_ += chosen_lines(network_file("/exact.c.in"), flags_);
    if (is("COUPLINGS")) text_ += chosen_lines(network_file("/couplings.c.in"), flags_);
    text_ += chosen_lines(network_file("/step.c.in"), flags_);
    if (is("SETTLES")) text_ += chosen_lines(network_file("/start.c.in"), flags_);
    if (is("FRICTIONS"))
      text_ +=
          "/// What presses the frictions.\nstatic inline void net_press(tactus_nodes* s, const tactus_real* "
          "in, int "
          "part) {\n" +
          presses() + "}\n";
    if (factored() && tables_.start_solver == tables_.solver)
      text_ = renamed(text_, {{"net_start_solve", "net_solve"}});
    std::set<std::string> wanted{"net_step"};
    for (const auto& value : values_) wanted.merge(identifiers_of(value));
    for (const auto& function : needed_functions(text_, wanted)) {
      auto text = with_names(without_unused_names(with_numbers_of(function)));
      // What runs once stays apart, as other such functions do.
      if (function.find(" net_settle(") != function.npos || function.find(" net_start(") != function.npos)
        text.replace(text.find("static inline"), 13, "static TACTUS_SELDOM");
      node_.function(text);
    }
  }

  /// Lists of equal numbers as this number.
  std::string with_numbers_of(const std::string& text) {
    std::string result;
    for_each_name(
        text,
        [&](const std::string& name, std::size_t end) {
          const auto literal = literal_of(name, text);
          if (literal.empty()) return result += name, end;
          int depth = 0;
          do depth += text[end] == '[' ? 1 : text[end] == ']' ? -1 : 0, ++end;
          while (depth > 0);
          return result += literal, end;
        },
        [&](char c) { result += c; });
    return result;
  }

  /// "": it is no list, or not all numbers are the same, or not all places take one of them.
  std::string literal_of(const std::string& name, const std::string& text) const {
    const auto value_of = [&](const auto& lists) -> std::string {
      const auto list = lists.find(name);
      if (list == lists.end() || list->second.empty() || !all_same(list->second)) return {};
      return number_text(list->second.front());
    };
    for (auto at = text.find(name); at != text.npos; at = text.find(name, at + 1)) {
      const auto end = at + name.size();
      if ((at == 0 || !is_identifier_part(text[at - 1])) && !is_identifier_part(text[end]) &&
          text[end] != '[')
        return {};
    }
    const auto literal = value_of(numbers_);
    return literal.empty() ? value_of(integers_) : literal;
  }

  std::string with_names(const std::string& text) {
    std::string result;
    for_each_name(
        text,
        [&](const std::string& name, std::size_t end) {
          const bool own = name.starts_with("net_") || name.starts_with("NET_");
          return result += own ? own_name(name) : name, end;
        },
        [&](char c) { result += c; });
    return result;
  }

  std::string own_name(const std::string& name) {
    if (const auto found = names_.find(name); found != names_.end()) return found->second;
    if (const auto found = constants_.find(name); found != constants_.end()) return with_names(found->second);
    const auto suffix = name.substr(4);
    if (const auto found = members_.find(name); found != members_.end()) {
      const auto& [type, count, bytes] = found->second;
      const auto member = node_.state(type, suffix, count, bytes);
      used_members_[name] = member;
      return names_[name] = member.substr(3);
    }
    if (const auto found = numbers_.find(name); found != numbers_.end())
      return names_[name] = node_.table(suffix, found->second.empty() ? Numbers{0.0} : found->second);
    if (const auto found = integers_.find(name); found != integers_.end())
      return names_[name] = integer_table(suffix, found->second);
    if (const auto found = structs_.find(name); found != structs_.end()) {
      const auto& [type, text, bytes] = found->second;
      return names_[name] = node_.table(type, suffix, "[]{" + text + "}", bytes);
    }
    return names_[name] = node_.function_name(suffix);
  }

  std::string integer_table(const std::string& suffix, Integers values) {
    if (values.empty()) values.push_back(0);  // C has no empty lists
    const auto texts = list_of(values, [](int value) { return number_text(value); });
    return node_.table("int", suffix, "[]" + c_list(texts, 16), sizeof(int) * values.size());
  }

  struct StructTable {
    std::string type, text;
    std::size_t bytes;
  };

  NodeWriter& node_;
  const Network& network_;
  const NetworkModel& model_;
  const SolverTables tables_;
  const Couplings& couplings_;
  const NetworkView& view_;
  NetworkState start_;
  std::vector<std::string> values_;  ///< [output]
  NetworkFlags flags_;
  std::string text_;
  std::map<std::string, std::string> constants_, names_, used_members_;
  std::map<std::string, Numbers> numbers_;
  std::map<std::string, Integers> integers_;
  std::map<std::string, StructTable> structs_;
  std::map<std::string, Member> members_;
};

void write_network(NodeWriter& node) {
  const auto& view = dynamic_cast<const NetworkView&>(*node.running());
  if (view.network.network_solver().tables().couplings == nullptr)
    return node.refuse("the solver 'reference' integrates with steps of any number",
                       "choose solver = \"auto\", or another one");
  NetworkWriter{node, view}.write();
}

constexpr NodeExport kNetworks[] = {{"network", write_network}};

}  // namespace

std::span<const NodeExport> exported_networks() { return kNetworks; }

}  // namespace tactus
