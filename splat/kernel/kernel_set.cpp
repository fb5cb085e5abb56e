#include "splat/kernel/kernel_set.h"

#include <algorithm>

#include "splat/kernel/kernel_maker.h"
#include "splat/kernel/kernel_order.h"

namespace swept {
namespace {

void sort_by_content(std::vector<MovingKernel>& kernels) {
  KernelOrder content;
  for (const MovingKernel& k : kernels) content.include(k);
  struct Entry {
    std::uint64_t key;
    std::size_t index;
  };
  std::vector<Entry> order(kernels.size());
  for (std::size_t i = 0; i < kernels.size(); ++i) order[i] = {content.key(kernels[i]), i};
  std::sort(order.begin(), order.end(), [&](const Entry& a, const Entry& b) {
    return a.key != b.key ? a.key < b.key : KernelOrder::content_less(kernels[a.index], kernels[b.index]);
  });
  // Along the cycles of the permutation: kernels are most of the memory, and a second set of them would
  // double it.
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (order[i].index == i) continue;
    const MovingKernel first = kernels[i];
    std::size_t to = i;
    for (std::size_t from = order[to].index; from != i; from = order[to].index) {
      kernels[to] = kernels[from];
      order[to].index = to;
      to = from;
    }
    kernels[to] = first;
    order[to].index = to;
  }
}

}  // namespace

KernelSet build_kernels(const Scene& scene, const Exposure& exposure, const std::stop_token& stop) {
  KernelSet set;
  KernelMaker maker(scene, exposure);
  set.projection = maker.projection();
  set.near = maker.near();
  set.kernels.reserve(maker.expected());
  static_cast<KernelCounts&>(set) = maker.make_all([&](const KernelSource&, const MovingKernel& kernel,
                                                       const DiscTurn*) { set.kernels.push_back(kernel); },
                                                   stop);
  if (!stop.stop_requested()) sort_by_content(set.kernels);
  return set;
}

}  // namespace swept
