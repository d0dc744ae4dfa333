#pragma once

#include <string>
#include <vector>

namespace tactus::bench {

/// One way of compiling what Faust made of a work; those that were linked in list themselves.
class FaustBuild {
 public:
  FaustBuild(std::string for_work, std::string with) : work(std::move(for_work)), name(std::move(with)) {
    all().push_back(this);
  }
  virtual ~FaustBuild() = default;
  FaustBuild(const FaustBuild&) = delete;
  FaustBuild& operator=(const FaustBuild&) = delete;

  virtual void clear() = 0;
  virtual void compute(int frames, float** in, float** out) = 0;

  static std::vector<FaustBuild*>& all() {
    static std::vector<FaustBuild*> builds;
    return builds;
  }

  const std::string work, name;
};

}  // namespace tactus::bench
