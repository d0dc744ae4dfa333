#include <fmt/format.h>

#include "export/targets/c_text.h"
#include "export/targets/target.h"

namespace tactus {
namespace {

/// Text as a literal of C.
std::string c_string(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result + "\"";
}

std::string double_text(double value) { return c_number(value, *find_number_type("double")); }

std::string pd_control_table(const CProgram& program) {
  if (program.controls.empty()) return "    {0, 0, 0, 0, 0}, /* there are no controls */\n";
  std::string text;
  for (const auto& control : program.controls)
    text +=
        fmt::format("    {{\"{0}\", offsetof(tactus_controls, {0}), {1}, {2},\n     {3}}},\n", control.name,
                    double_text(control.low), double_text(control.high), c_string(control.about));
  return text;
}

constexpr const char* kPdObject = R"(#include <math.h>
#include <stddef.h>

#include "m_pd.h"
#include "tactus.h"

/* A message of the name of a control sets it. */
typedef struct tactus_tilde_control {
  const char* name;
  size_t offset; /* in tactus_controls */
  double low, high;
  const char* about;
} tactus_tilde_control;

static const tactus_tilde_control tactus_tilde_controls[] = {
@controls};

typedef struct tactus_tilde {
  t_object object;
  t_float first; /* signal of the first inlet while nothing is connected */
  int frames;        /* of a block */
  double last_block; /* logical time */
@state  unsigned char clamped[TACTUS_CONTROLS + 1]; /* whether that was said */
  tactus program;
} tactus_tilde;

static t_class* tactus_tilde_class;

/* Denormal numbers count as 0, as in the engine; many processors are slow with them. */
#if defined(__SSE2__) || defined(_M_X64)
#include <xmmintrin.h>
typedef unsigned int tactus_tilde_mode;
static tactus_tilde_mode tactus_tilde_flush(void) {
  const tactus_tilde_mode before = _mm_getcsr();
  _mm_setcsr(before | 0x8040);
  return before;
}
static void tactus_tilde_restore(tactus_tilde_mode before) { _mm_setcsr(before); }
#elif defined(__aarch64__) && defined(__GNUC__)
typedef unsigned long long tactus_tilde_mode;
static tactus_tilde_mode tactus_tilde_flush(void) {
  tactus_tilde_mode before;
  __asm__ volatile("mrs %0, fpcr" : "=r"(before));
  __asm__ volatile("msr fpcr, %0" : : "r"(before | 0x1000000));
  return before;
}
static void tactus_tilde_restore(tactus_tilde_mode before) {
  __asm__ volatile("msr fpcr, %0" : : "r"(before));
}
#else
typedef int tactus_tilde_mode;
static tactus_tilde_mode tactus_tilde_flush(void) { return 0; }
static void tactus_tilde_restore(tactus_tilde_mode before) { (void)before; }
#endif

static tactus_real* tactus_tilde_value(tactus_tilde* x, const tactus_tilde_control* control) {
  return (tactus_real*)((char*)&x->program.controls + control->offset);
}

@disarm/* All nodes as they were at the start; controls stay. */
static void tactus_tilde_restart(tactus_tilde* x) {
  const tactus_controls controls = x->program.controls;
  tactus_init(&x->program);
  x->program.controls = controls;
@restarted}

/* Whether the last block is longer ago than one: DSP, or a switch~ around the object, is or was off. */
static int tactus_tilde_paused(const tactus_tilde* x) {
  const int longest = x->frames > sys_getblksize() ? x->frames : sys_getblksize();
  return clock_gettimesince(x->last_block) > 1500.0 * longest / TACTUS_RATE;
}

static t_int* tactus_tilde_perform(t_int* w) {
  tactus_tilde* x = (tactus_tilde*)w[1];
  const int frames = (int)w[2];
  const tactus_tilde_mode mode = tactus_tilde_flush();
  if (tactus_tilde_paused(x)) tactus_tilde_restart(x);
  x->last_block = clock_getlogicaltime();
@alive  /* Outputs may share their samples with inputs: a frame is read before it is written. */
  for (int n = 0; n < frames; ++n) {
    tactus_real in[TACTUS_INPUTS + 1], out[TACTUS_OUTPUTS + 1];
    for (int k = 0; k < TACTUS_INPUTS; ++k) in[k] = ((const t_sample*)w[3 + k])[n];
    tactus_step(&x->program, in, out);
    for (int k = 0; k < TACTUS_OUTPUTS; ++k) ((t_sample*)w[3 + TACTUS_INPUTS + k])[n] = (t_sample)out[k];
  }
  tactus_tilde_restore(mode);
  return w + 3 + TACTUS_INPUTS + TACTUS_OUTPUTS;
}

static void tactus_tilde_dsp(tactus_tilde* x, t_signal** signals) {
  t_int words[2 + TACTUS_INPUTS + TACTUS_OUTPUTS];
  if (signals[0]->s_sr != (t_float)TACTUS_RATE) {
    pd_error(x, "tactus~: exported for %g Hz, but Pd runs at %g Hz: silent. Set Pd's rate, or export with --rate",
             (double)TACTUS_RATE, (double)signals[0]->s_sr);
    for (int k = 0; k < TACTUS_OUTPUTS; ++k)
      dsp_add_zero(signals[TACTUS_INPUTS + k]->s_vec, signals[TACTUS_INPUTS + k]->s_n);
    return;
  }
@unarmed  x->frames = signals[0]->s_n;
  words[0] = (t_int)x;
  words[1] = (t_int)signals[0]->s_n;
  for (int k = 0; k < TACTUS_INPUTS + TACTUS_OUTPUTS; ++k) words[2 + k] = (t_int)signals[k]->s_vec;
  dsp_addv(tactus_tilde_perform, 2 + TACTUS_INPUTS + TACTUS_OUTPUTS, words);
}

@armstatic void tactus_tilde_set(tactus_tilde* x, int index, double value) {
  const tactus_tilde_control* control = &tactus_tilde_controls[index];
  const double inside = value < control->low ? control->low : value > control->high ? control->high : value;
  if (value != value) {
    pd_error(x, "tactus~: %s: not a number; the value stays", control->name);
    return;
  }
  if (inside != value && !x->clamped[index]) {
    pd_error(x, "tactus~: %s %g is outside of %g to %g and counts as %g; further ones are not reported",
             control->name, value, control->low, control->high, inside);
    x->clamped[index] = 1;
  }
  *tactus_tilde_value(x, control) = (tactus_real)inside;
}

static void tactus_tilde_anything(tactus_tilde* x, t_symbol* name, int count, t_atom* values) {
  int index = 0;
  while (index < TACTUS_CONTROLS && name != gensym(tactus_tilde_controls[index].name)) ++index;
  if (index == TACTUS_CONTROLS)
    pd_error(x, "tactus~: no control is called '%s'; the message 'print' lists them", name->s_name);
  else if (count != 1 || values[0].a_type != A_FLOAT)
    pd_error(x, "tactus~: '%s' takes one number", name->s_name);
  else
    tactus_tilde_set(x, index, atom_getfloat(values));
}

static void tactus_tilde_print(tactus_tilde* x) {
@printed  for (int k = 0; k < TACTUS_CONTROLS; ++k) {
    const tactus_tilde_control* control = &tactus_tilde_controls[k];
    post("%s %g: %s", control->name, (double)*tactus_tilde_value(x, control), control->about);
  }
}

static void* tactus_tilde_new(void) {
  tactus_tilde* x = (tactus_tilde*)pd_new(tactus_tilde_class);
  tactus_init(&x->program);
  x->last_block = -HUGE_VAL;
  for (int k = 1; k < TACTUS_INPUTS; ++k) inlet_new(&x->object, &x->object.ob_pd, &s_signal, &s_signal);
  for (int k = 0; k < TACTUS_OUTPUTS; ++k) outlet_new(&x->object, &s_signal);
  return x;
}

#ifdef _WIN32
__declspec(dllexport)
#endif
void tactus_tilde_setup(void) {
  tactus_tilde_class = class_new(gensym("tactus~"), (t_newmethod)tactus_tilde_new, 0, sizeof(tactus_tilde),
                                 CLASS_DEFAULT, A_NULL);
@main_inlet  class_addmethod(tactus_tilde_class, (t_method)tactus_tilde_dsp, gensym("dsp"), A_CANT, A_NULL);
@methods  class_addmethod(tactus_tilde_class, (t_method)tactus_tilde_print, gensym("print"), A_NULL);
  class_addanything(tactus_tilde_class, (t_method)tactus_tilde_anything);
}
)";

/// What a program with a guard has: it starts disarmed, and a disarmed one fades out.
constexpr const char* kPdDisarm =
    R"(/* The fade-out begins at once, not when the dead man's switch has run out. */
static void tactus_tilde_disarm(tactus_tilde* x) {
  x->armed = 0;
  x->program.alive.left = 0;
}

)";
constexpr const char* kPdArm = R"(static void tactus_tilde_arm(tactus_tilde* x) {
  x->armed = !tactus_tilde_paused(x);
  if (!x->armed) pd_error(x, "tactus~: not armed: no block was computed; switch DSP on first");
}

)";

std::string with_part(std::string text, const std::string& name, const std::string& with) {
  const auto at = text.find("@" + name);
  return text.replace(at, name.size() + 1, with);
}

std::string pd_object(const CProgram& program) {
  const bool guard = program.guard;
  auto text = fmt::format("/* {}: the object tactus~ of Pure Data. README.md says how it is used. */\n",
                          program.title) +
              kPdObject;
  text = with_part(text, "state", guard ? "  int armed, said;   /* said: that it is not armed */\n" : "");
  text = with_part(text, "disarm", guard ? kPdDisarm : "");
  text = with_part(text, "restarted", guard ? "  tactus_tilde_disarm(x);\n" : "");
  text = with_part(text, "alive", guard ? "  if (x->armed) tactus_alive(&x->program);\n" : "");
  text = with_part(text, "unarmed",
                   guard ? "  if (!x->armed && !x->said)\n"
                           "    post(\"tactus~: the outputs are 0 until the message 'arm'\");\n"
                           "  x->said = 1;\n"
                         : "");
  text = with_part(text, "arm", guard ? kPdArm : "");
  text = with_part(text, "printed",
                   guard ? "  post(\"tactus~: %s\", x->armed ? \"armed\" : \"not armed\");\n" : "");
  text = with_part(
      text, "main_inlet",
      program.inputs.empty() ? "" : "  CLASS_MAINSIGNALIN(tactus_tilde_class, tactus_tilde, first);\n");
  text = with_part(
      text, "methods",
      guard ? "  class_addmethod(tactus_tilde_class, (t_method)tactus_tilde_arm, gensym(\"arm\"), A_NULL);\n"
              "  class_addmethod(tactus_tilde_class, (t_method)tactus_tilde_disarm, gensym(\"disarm\"), "
              "A_NULL);\n"
            : "");
  text = with_part(text, "controls", pd_control_table(program));
  auto doubles = program;  // Pd's side calculates in doubles, whatever the program does
  doubles.number = find_number_type("double");
  return as_of_program(text, doubles);
}

std::string pd_makefile(const CProgram& program) {
  return fmt::format(
      R"(# Builds {0}~ for Pure Data. `make PDINCLUDE=FOLDER` where m_pd.h is not in the compiler's own folders;
# `make install` copies it to where Pd looks for externals. On Windows (MSYS2) PDBIN is the folder of pd.dll.
PDINCLUDE ?=
PDBIN ?=
PDLIBDIR ?= $(HOME)/.local/lib/pd/extra

CFLAGS ?= -O2
# Products and sums are not fused, so that results are those of the engine.
needed = -std=c99 -fPIC -ffp-contract=off $(if $(PDINCLUDE),-I$(PDINCLUDE))

system := $(shell uname -s)
ifeq ($(system),Darwin)
  suffix = pd_darwin
  shared = -bundle -undefined dynamic_lookup
  PDLIBDIR = $(HOME)/Library/Pd
else ifneq ($(findstring MINGW,$(system)),)
  suffix = dll
  shared = -shared -static-libgcc $(if $(PDBIN),-L$(PDBIN)) -lpd
else
  suffix = pd_linux
  shared = -shared
endif

{0}~.$(suffix): {0}~.c {0}.c {0}.h
	$(CC) $(CPPFLAGS) $(CFLAGS) $(needed) -o $@ {0}~.c {0}.c $(LDFLAGS) $(shared) -lm

install: {0}~.$(suffix)
	mkdir -p "$(DESTDIR)$(PDLIBDIR)/{0}~"
	cp {0}~.$(suffix) {0}~-help.pd README.md "$(DESTDIR)$(PDLIBDIR)/{0}~"

clean:
	rm -f {0}~.$(suffix)

.PHONY: install clean
)",
      program.name);
}

/// A patch: objects below each other, and lines between them.
class PdHelpPatch {
 public:
  /// Returns the number of the object.
  int add(const char* kind, int x, const std::string& text) {
    boxes_ += fmt::format("#X {} {} {} {}", kind, x, y_, escaped(text));
    return count_++;
  }
  int comment(int x, const std::string& text) {
    const int number = add("text", x, text);
    boxes_ += ", f 90";
    end(text.size() > 90 ? 40 : 24);
    return number;
  }
  int box(const char* kind, int x, const std::string& text, int height = 26) {
    const int number = add(kind, x, text);
    end(height);
    return number;
  }
  /// A box with a comment beside it.
  int labelled(const char* kind, const std::string& text, const std::string& about) {
    const int number = box(kind, 40, text, 0);
    comment(230, about);
    return number;
  }
  void connect(int from, int outlet, int to, int inlet) {
    lines_ += fmt::format("#X connect {} {} {} {};\n", from, outlet, to, inlet);
  }
  void gap() { y_ += 12; }
  std::string text() const { return fmt::format("#N canvas 60 60 860 {} 12;\n", y_ + 60) + boxes_ + lines_; }

 private:
  static std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
      if (c == ',' || c == ';' || c == '$') result += " \\";
      result += c;
    }
    return result;
  }
  void end(int height) {
    boxes_ += ";\n";
    y_ += height;
  }

  std::string boxes_, lines_;
  int count_ = 0, y_ = 20;
};

std::string pd_help_patch(const CProgram& program) {
  PdHelpPatch patch;
  patch.comment(20, program.name + "~: " + (program.about.empty() ? program.title : program.about));
  patch.comment(20, fmt::format("For {:g} Hz only: at another rate it is silent and reports an error.",
                                program.sample_rate.value));
  patch.gap();
  std::vector<int> messages;
  if (program.guard) {
    messages.push_back(patch.labelled("msg", "arm", "soft start of the outputs, which are 0 before"));
    messages.push_back(patch.labelled("msg", "disarm", "safe stop: the outputs fade out"));
  }
  for (const auto& control : program.controls)
    messages.push_back(
        patch.labelled("msg", fmt::format("{} {:.9g}", control.name, control.value), control.about));
  messages.push_back(patch.labelled("msg", "print", "lists the controls in the Pd window"));
  patch.gap();
  std::vector<int> inputs;
  for (std::size_t k = 0; k < program.inputs.size(); ++k)
    inputs.push_back(patch.labelled(
        "obj", fmt::format("adc~ {}", k + 1),
        fmt::format("inlet {}: {} {}", k + 1, program.inputs[k].name, program.inputs[k].about)));
  const int object = patch.box("obj", 40, program.name + "~", 34);
  for (std::size_t k = 0; k < program.outputs.size(); ++k)
    patch.comment(40, fmt::format("outlet {}: {} {}", k + 1, program.outputs[k].name,
                                  program.outputs[k].audio ? "(sound)" : "(actuator)"));
  patch.comment(40, "Connect the outlets to the channels of dac~ where sound and actuators really are.");
  for (const int message : messages) patch.connect(message, 0, object, 0);
  for (std::size_t k = 0; k < inputs.size(); ++k) patch.connect(inputs[k], 0, object, static_cast<int>(k));
  return patch.text();
}

std::string pd_port_rows(const char* what, const std::vector<ProgramPort>& ports) {
  std::string text;
  for (std::size_t k = 0; k < ports.size(); ++k)
    text +=
        fmt::format("| {} {} | {} | {} | {} |\n", what, k + 1, ports[k].name, ports[k].unit, ports[k].about);
  return text;
}

std::string pd_message_rows(const CProgram& program) {
  std::string text;
  for (const auto& control : program.controls)
    text += fmt::format("| `{} {:.9g}` | {} |\n", control.name, control.value, control.about);
  return text;
}

std::string pd_stopping(const CProgram& program) {
  if (!program.guard) return "## Limits\n\n" + limits_section(program);
  return fmt::format(R"(## Safe start and stop

The outputs are 0 until the message `arm`, which needs DSP on, and then start softly. **`disarm` is the safe stop: all outputs fade out.**
Send it, and wait for the fade-out, before you switch DSP off, close the patch or delete the object: Pd itself then stops in the
middle of the signal, and no object can fade that. After DSP (or a `switch~` around the object) was off, the object starts anew
and is not armed; its controls stay. Editing a patch while DSP runs changes nothing.

## Limits

{})",
                     limits_section(program));
}

std::string pd_readme(const CProgram& program) {
  return fmt::format(
      "# {0}~\n\n{1}\n\nA signal object for Pure Data, exported by Tactus from `{2}` for {3:g} Hz. At "
      "another "
      "rate it is silent and "
      "reports an error. Blocks may have any size (`block~`); the result is the same.\n\n## Build\n\n"
      "```sh\nmake                 # needs m_pd.h: the package puredata-dev, or make PDINCLUDE=FOLDER\n"
      "make install         # copies it to where Pd looks for externals\n```\n\n"
      "Linux, macOS and Windows (MSYS2, `make PDBIN=FOLDER`). For a Pd with 64-bit samples: "
      "`make CPPFLAGS=-DPD_FLOATSIZE=64`, and rename the file as that Pd expects it.\n\n"
      "## Inlets and outlets\n\n| | name | unit | |\n|---|---|---|---|\n{4}{5}\n"
      "## Messages\n\nTo the first inlet, in SI units. A value outside of the range is clamped, and the Pd "
      "window says so once for each control; "
      "`print` lists all values.\n\n| at the start | |\n|---|---|\n{6}| `print` | lists the controls |\n{7}\n"
      "{8}\n## Numbers\n\nThe program calculates with {9}s; Pd's samples and messages are single-precision. "
      "An output differs "
      "from that of Tactus by the rounding to a sample.\n",
      program.name, program.about.empty() ? program.title : program.about, program.file,
      program.sample_rate.value, pd_port_rows("inlet", program.inputs),
      pd_port_rows("outlet", program.outputs), pd_message_rows(program), fixed_section(program),
      pd_stopping(program), program.number->c_type);
}

}  // namespace

std::vector<ExportedFile> pd_files(const CProgram& program) {
  return {{program.name + ".h", c_header(program)},   {program.name + ".c", c_source(program)},
          {program.name + "~.c", pd_object(program)}, {program.name + "~-help.pd", pd_help_patch(program)},
          {"Makefile", pd_makefile(program)},         {"README.md", pd_readme(program)}};
}

}  // namespace tactus
