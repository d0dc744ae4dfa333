#include "apps/render/rendered_files.h"

#include <algorithm>

namespace tactus::app {

Status write_outputs(const RenderedFiles& files, const Samples& outputs,
                     const std::vector<std::string>& names, const std::vector<std::string>& sounds) {
  const auto encoding = files.format == "24" ? WavEncoding::Pcm24 : WavEncoding::Float32;
  if (!files.out.empty())
    if (auto status = write_wav(files.out, outputs, encoding); !status) return status;
  if (files.sound.empty()) return {};
  if (sounds.empty())
    return fail(Errc::BadArgument, "--sound", "this instrument gives nothing to the ears",
                "leave it out, or give an output the kind \"audio\"");
  Samples heard{outputs.sample_rate, {}};
  for (const auto& sound : sounds) {
    const auto place = std::find(names.begin(), names.end(), sound) - names.begin();
    heard.channels.push_back(outputs.channels[static_cast<std::size_t>(place)]);
  }
  return write_wav(files.sound, heard, encoding);
}

}  // namespace tactus::app
