#include "kernels/core/launch.cuh"
#include "problems/gaussian_splatting/adam/device_updates.h"
#include "problems/gaussian_splatting/model/length_unit_formula.h"

namespace vesta::gs::device_updates {
namespace {

// Memory bound: reads and writes 16 bytes a parameter that moves, reads 4 of others.
struct StepOne {
  AdamArrays a;
  VESTA_HD void operator()(Index parameter) const {
    const Index i = a.first_attribute * a.count + parameter, attribute = i / a.count;
    if (a.gradient[i] == 0) return;
    const float unit = attribute < splat::kLogScale ? a.units[i - attribute * a.count] : 1.0f;
    const float step = AdamStep(a.gradient[i], unit * a.rate[attribute], a.root_correction2, a.first[i], a.second[i]);
    a.gradient[i] = 0;
    a.parameters[i] -= step;
  }
};

struct StepBlock {
  BlockAdamArrays a;
  VESTA_HD void operator()(Index i) const { BlockAdamStep<float>(a, i); }
};

// Three matrices, which registers do not hold: they are in local memory, for one Gaussian in 25.
struct TurnOne {
  BlockAdamArrays a;
  Index first_chunk;
  VESTA_HD void operator()(Index turned) const {
    const Index chunk = first_chunk + turned / kTurnChunk * kTurnEvery;
    const Index i = chunk * kTurnChunk + turned % kTurnChunk;
    if (i < a.count) TurnBasis<float>(a, i);
  }
};

struct GatherOne {
  RowGathering g;
  VESTA_HD void operator()(Index entry) const {
    const Index attribute = entry / g.to_rows, row = entry - attribute * g.to_rows;
    g.to[entry] = !g.kept || g.kept[row] != 0 ? g.from[attribute * g.from_rows + g.source[row]] : 0.0f;
  }
};

struct GatherBasisNumber {
  BaseGathering g;
  // entry: as BlockEntry gives them.
  VESTA_HD void operator()(Index entry) const {
    const Index block = entry / (kBlockNumbers * kBlockLanes), in_block = entry - block * kBlockNumbers * kBlockLanes;
    const int number = static_cast<int>(in_block / kBlockLanes);
    const Index i = block * kBlockLanes + in_block % kBlockLanes;
    const bool is_kept = i < g.to_rows && (g.kept[i] != 0 || number < kBasisSize);
    g.to[entry] = is_kept ? g.from[BlockEntry(number, g.source[i])] : 0.0f;
  }
};

struct MeasureUnit {
  Index count;
  const float* parameters;
  const splat::PinholeView* views;
  Index num_views;
  double otherwise;
  float* units;
  VESTA_HD void operator()(Index i) const {
    float mean[3];
    for (int k = 0; k < 3; ++k) mean[k] = parameters[(splat::kMean + k) * count + i];
    units[i] = LengthUnit(views, num_views, otherwise, mean);
  }
};

}  // namespace

void StepAdam(const AdamArrays& arrays) {
  device::ForEach((arrays.attributes - arrays.first_attribute) * arrays.count, StepOne{arrays}, "step of Adam");
}

void StepBlocks(const BlockAdamArrays& arrays) {
  device::ForEach(arrays.count, StepBlock{arrays}, "step of Adam's blocks");
}

void TurnBases(const BlockAdamArrays& arrays, int steps) {
  const Index chunks = (arrays.count + kTurnChunk - 1) / kTurnChunk, first = FirstTurned(steps);
  const Index turned = chunks > first ? (chunks - first + kTurnEvery - 1) / kTurnEvery : 0;
  device::ForEach(turned * kTurnChunk, TurnOne{arrays, first}, "turn of Adam's bases");
}

void GatherRows(const RowGathering& gathering) {
  device::ForEach(gathering.attributes * gathering.to_rows, GatherOne{gathering}, "gathering of rows");
}

void GatherBases(const BaseGathering& gathering) {
  device::ForEach(BlockArraySize(gathering.to_rows), GatherBasisNumber{gathering}, "gathering of Adam's bases");
}

void MeasureUnits(Index count, const float* parameters, const splat::PinholeView* views, Index num_views,
                  double otherwise, float* units) {
  device::ForEach(count, MeasureUnit{count, parameters, views, num_views, otherwise, units}, "units of length");
}

}  // namespace vesta::gs::device_updates
