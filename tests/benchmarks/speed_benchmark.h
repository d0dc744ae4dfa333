#pragma once

namespace tactus::bench {

/// Registers the works of docs/performance.md with everybody who does them.
void add_speed_benchmarks();

}  // namespace tactus::bench
