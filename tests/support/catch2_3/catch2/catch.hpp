#pragma once
// The header of Catch2 2, by which tests include it, where only Catch2 3 is installed.

#include <catch2/catch_all.hpp>
#include <string>

namespace Catch {

using Matchers::WithinAbs;
using TestEventListenerBase = EventListenerBase;

inline auto Contains(const std::string& text) { return Matchers::ContainsSubstring(text); }

namespace Detail {
using Catch::Approx;
}

}  // namespace Catch

using Catch::Approx;
