#include <cmath>
#include <cstring>

#include "problems/gaussian_splatting/io/ply.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

void PromiseSplat(const gs::SplatModel& model) {
  Promise(model.sh_degree >= 0 && model.sh_degree <= 3 && model.count > 0, "no splat");
  Promise(static_cast<Index>(model.data.size()) == model.count * model.num_attributes(), "values of another number");
  for (const float value : model.data) Promise(std::isfinite(value), "a value that is not finite");
  for (Index i = 0; i < model.count; ++i) {
    bool is_zero = true;
    for (int k = 0; k < 4; ++k) is_zero = is_zero && model.attribute(splat::kQuaternion + k)[i] == 0;
    Promise(!is_zero, "a quaternion of zero");
  }
  for (const float channel : model.background) Promise(channel >= 0 && channel <= 1, "a background beyond 0..1");
  for (const double value : model.origin) Promise(std::isfinite(value), "an origin that is not finite");
}

bool Same(const gs::SplatModel& a, const gs::SplatModel& b) {
  return a.sh_degree == b.sh_degree && a.count == b.count && a.has_background == b.has_background &&
         a.background == b.background && a.origin == b.origin && a.data.size() == b.data.size() &&
         std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0;
}

}  // namespace

void FuzzSplatPly(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.Write("splat.ply", bytes), copy = folder / "copy.ply";
  for (const bool drop : {true, false}) {
    gs::SplatModel model;
    if (!Reads(path, [&] { model = gs::ReadSplatPly(path, {.drop_unusable = drop}); })) continue;
    PromiseSplat(model);
    gs::WriteSplatPly(copy, model);
    Promise(Same(model, gs::ReadSplatPly(copy)), "written and read again it is another splat");
  }
}

}  // namespace vesta::fuzz
