#pragma once

// Thread: [control], except where a function says otherwise
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/graph/body_source.h"
#include "engine/nodes/networks/network_elements.h"

// The table of the elements of worlds: rigid bodies, what joins them, what acts on them and what is read of
// them. All behaviour of an element's type is in its entry.
namespace tactus {

/// More are refused: every pair of them is tested for contact in each step.
inline constexpr int kMostBodies = 500;
inline constexpr double kLeastSize_m = 1e-6, kLeastMass_kg = 1e-9;

/// What an element becomes.
enum class WorldPart { Body, Joint, Link, Handle, Gravity, Collision };
enum class WorldShape { Sphere, Box, Capsule, Plane };
/// In the order of kJointNames.
enum class WorldJoint { Hinge, Slider, Ball, Fixed, Universal, Hinge2, Piston };
inline constexpr int kJointKinds = static_cast<int>(kJointNames.size());

/// How an output follows the steps of the world: on a line from one step to the next, held, 1 in the first
/// frame of a step, or computed in each frame.
enum class WorldReading { Line, Held, Trigger, Frame };

struct WorldQuantity {
  std::string name;
  std::string unit;
  std::string doc;
  WorldReading reading = WorldReading::Held;
  bool event_level = false;  ///< how strong the last event was
};

/// The declaration of a type of element.
struct WorldElementType {
  using Ends = ElementType::Ends;  ///< None, On (a body) or Against (`against` left out: the world)
  std::string name;
  std::string doc;
  std::string equation;
  WorldPart part;
  Ends ends;
  std::vector<Setting> settings = {};
  std::vector<ElementField> fields = {};
  std::vector<WorldQuantity> quantities = {};  ///< the first is what the element's bare name means
  std::string example;
  WorldShape shape = WorldShape::Sphere;  ///< of a body
  WorldJoint joint = WorldJoint::Hinge;   ///< of a joint
};

/// [any] All of them, in the order of the reference.
std::span<const WorldElementType> world_elements();
/// [any] nullptr if there is no such type.
const WorldElementType* find_world_element(std::string_view name);
/// [any] The keys of `[worlds.name]` that are no elements.
const SectionType& world_options();
/// [any] What a world is asked for besides the quantities of its elements.
std::span<const WorldQuantity> world_quantities();

// Settings that the world's node reads by name.
inline constexpr const char* kMotionOfBody = "body";
inline constexpr const char* kFixedBody = "fixed";
inline constexpr const char* kCollides = "collides";
inline constexpr const char* kCollidesNot = "none";
inline constexpr const char* kRemote = "remote";
inline constexpr const char* kRemoteYes = "yes";

}  // namespace tactus
