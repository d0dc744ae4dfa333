#pragma once

#include <dlfcn.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/core/realtime.h"
#include "engine/nodes/table.h"
#include "export/export.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"

namespace tactus::test {

/// What tests export with if they do not say otherwise: the bits of the engine, without a guard.
inline ExportOptions exact_options() {
  ExportOptions options;
  options.target = find_export_target("c");
  options.number = find_number_type("double");
  return options;
}

/// Exported programs, compiled as they are meant to be and loaded into this process. Skips the test where
/// there is no C compiler.
class CompiledPrograms {
 public:
  ~CompiledPrograms() {
    if (library_ != nullptr) dlclose(library_);
  }
  CompiledPrograms() = default;
  CompiledPrograms(const CompiledPrograms&) = delete;
  CompiledPrograms& operator=(const CompiledPrograms&) = delete;

  /// "" or why it cannot be exported. `file`: what paths in the text start from.
  std::string add(const std::string& text, const ExportOptions& options,
                  const std::string& file = "test.toml") {
    return add(parse_graph_leniently(text, file), options);
  }
  std::string add(const LoadedGraph& graph, const ExportOptions& options) {
    const auto program = write_program(graph, standard_nodes(), options);
    if (!program) return full_text(program.error());
    for (const auto& file : options.target->files(*program))
      if (file.name.starts_with(program->name)) folder_.write(file.name, file.text);
    folder_.write(program->name + "_test.c", harness(program->name));
    sources_ += " " + program->name + "_test.c";
    programs_.emplace(program->name, *program);
    return {};
  }
  const CProgram& program(const std::string& name) const { return programs_.at(name); }

  /// Compiles all that were added.
  void compile(const std::string& flags = "-O1") {
    if (std::system(TACTUS_C_COMPILER " --version > /dev/null 2>&1") != 0) skip("there is no C compiler");
    const auto command = "cd " + folder_.path().string() +
                         " && " TACTUS_C_COMPILER " -std=c99 -pedantic -Wall -Wextra " + flags +
                         " -ffp-contract=off " TACTUS_MARCH_FLAG " -shared -fPIC" + sources_ +
                         " -lm -o programs.so > messages 2>&1";
    const bool compiled = std::system(command.c_str()) == 0;
    if (const auto text = read("messages"); !compiled || !text.empty()) throw std::runtime_error(text);
    library_ = dlopen((folder_.path() / "programs.so").c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) throw std::runtime_error(dlerror());
  }

  /// A program, started anew.
  class Running {
   public:
    Running(void* library, const std::string& name)
        : set_(function<void(int, double)>(library, name + "_test_set")),
          alive_(function<void()>(library, name + "_test_alive")),
          size_(function<int()>(library, name + "_test_size")),
          step_(function<void(const double*, double*)>(library, name + "_test_step")) {
      function<void()>(library, name + "_test_init")();
    }
    void set(int control, double value) const { set_(control, value); }
    void alive() const { alive_(); }
    std::size_t size() const { return static_cast<std::size_t>(size_()); }
    void step(const double* in, double* out) const { step_(in, out); }

   private:
    template <class Function>
    static Function* function(void* library, const std::string& name) {
      auto* const found = reinterpret_cast<Function*>(dlsym(library, name.c_str()));
      if (found == nullptr) throw std::runtime_error("no function " + name);
      return found;
    }
    void (*set_)(int, double);
    void (*alive_)();
    int (*size_)();
    void (*step_)(const double*, double*);
  };
  Running start(const std::string& name) const { return {library_, name}; }

  /// A control's new value before a frame.
  struct Move {
    int frame;
    std::string control;
    double value;
  };
  Channels run(const std::string& name, const Channels& inputs, int frames,
               const std::vector<Move>& moves = {}) const {
    const auto& program = programs_.at(name);
    const auto running = start(name);
    Channels out(program.outputs.size(), std::vector<double>(static_cast<std::size_t>(frames)));
    std::vector<double> in(inputs.size() + 1), now(out.size() + 1);
    const NoDenormals no_denormals;
    for (std::size_t n = 0; n < static_cast<std::size_t>(frames); ++n) {
      for (const auto& move : moves)
        if (move.frame == static_cast<int>(n)) set(running, program, move);
      for (std::size_t c = 0; c < inputs.size(); ++c) in[c] = inputs[c][n];
      running.step(in.data(), now.data());
      for (std::size_t c = 0; c < out.size(); ++c) out[c][n] = now[c];
    }
    return out;
  }

 private:
  static void set(const Running& running, const CProgram& program, const Move& move) {
    for (std::size_t i = 0; i < program.controls.size(); ++i)
      if (program.controls[i].name == move.control) running.set(static_cast<int>(i), move.value);
  }

  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream{folder_.path() / name}.rdbuf();
    return text.str();
  }

  /// With its program in one compilation, which takes half the time of two. The controls are numbers one
  /// behind the other.
  static std::string harness(const std::string& name) {
    std::string text = R"(#include "NAME.c"
void NAME_test_init(void);
void NAME_test_alive(void);
int NAME_test_size(void);
void NAME_test_set(int control, double value);
void NAME_test_step(const double* in, double* out);
static NAME program;
void NAME_test_init(void) { NAME_init(&program); }
void NAME_test_alive(void) { NAME_alive(&program); }
int NAME_test_size(void) { return (int)sizeof program; }
void NAME_test_set(int control, double value) { ((NAME_number*)&program.controls)[control] = (NAME_number)value; }
void NAME_test_step(const double* in, double* out) {
  NAME_number i[(sizeof(NAME_number) + 4) * 400], o[4000];
  for (int k = 0; k < UPPER_INPUTS; ++k) i[k] = (NAME_number)in[k];
  NAME_step(&program, i, o);
  for (int k = 0; k < UPPER_OUTPUTS; ++k) out[k] = (double)o[k];
}
)";
    std::string capitals = name;
    for (auto& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    const auto replace = [&](const std::string& from, const std::string& to) {
      for (auto at = text.find(from); at != text.npos; at = text.find(from, at + to.size()))
        text.replace(at, from.size(), to);
    };
    replace("UPPER", capitals);
    replace("NAME", name);
    return text;
  }

  TemporaryFolder folder_;
  std::string sources_;
  std::map<std::string, CProgram> programs_;
  void* library_ = nullptr;
};

/// The engine, compiled as the exporter compiles: no lanes in vectors.
inline Player engine_for(const LoadedGraph& graph, const ExportOptions& options) {
  CompileOptions compiling;
  compiling.sample_rate = options.sample_rate;
  compiling.system_delay = options.system_delay;
  compiling.controls = options.controls;
  compiling.vectorise = false;
  auto plan = compile(graph, standard_nodes(), compiling);
  if (!plan) throw std::runtime_error(full_text(plan.error()));
  return Player{std::move(*plan)};
}

}  // namespace tactus::test
