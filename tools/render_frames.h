// The frames of a run, one after the other: loaded, rendered, written.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "splat/io/scene_file.h"
#include "splat/result.h"
#include "tools/frame_renderer.h"
#include "tools/outputs.h"
#include "tools/stats_json.h"

namespace swept {

using FrameRemarks = std::function<std::vector<std::string>(const Scene&)>;

/// Renders the outputs that are not to be skipped, and adds one entry for each output to `run.frames`, all in
/// the order of the outputs. As many frames are in flight as the renderer takes: one is written while the
/// next is rendered, if the renderer can. Tells progress and the readers' notes on stderr.
///
/// While a frame is rendered, the next one is loaded, if `ahead`: what sequences show of it, for one frame at
/// most.
///
/// `remarks`, if any, is asked for more notes on each loaded frame, which are told before it is rendered.
///
/// The error is that of the first frame that failed. Those before it are written, it and those after it are
/// not.
[[nodiscard]] Status render_frames(SceneFile& file, const std::vector<FrameOutput>& outputs,
                                   FrameRenderer& renderer, RunStatistics& run, bool ahead = true,
                                   const FrameRemarks& remarks = {});

}  // namespace swept
