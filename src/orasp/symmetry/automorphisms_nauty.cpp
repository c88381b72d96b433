// The automorphisms of a graph, by nauty. The only file that includes it; made into a module.

#include <algorithm>
#include <numeric>
#include <vector>

#include <nauty/nausparse.h>

#include "orasp/symmetry/automorphisms.h"

namespace orasp {
namespace {

/// Where the callbacks of the search under way write. Nauty's own state is by thread as well.
thread_local Automorphisms* found = nullptr;

// NOLINTNEXTLINE(readability-non-const-parameter): nauty's type.
void note_generator(int, int* to, int*, int, int, int size) {
  found->generators.emplace_back(to, to + size);
}

// The order of the group is the product of the lengths of orbits, a factor at each level.
void note_level(int*, int*, int, int*, statsblk*, int, int index, int, int, int, int) {
  if (index > 1) found->order.push_back(static_cast<std::uint32_t>(index));
}

class NautyFinder : public AutomorphismFinder {
 public:
  [[nodiscard]] Automorphisms find(const ColouredGraph& graph) const override {
    Automorphisms all;
    const std::size_t size = graph.size();
    if (size == 0) return all;
    std::vector<std::size_t> begin(size, 0);
    std::vector<int> degree(size, 0);
    for (const auto& [a, b] : graph.edges) {
      ++degree[a];
      ++degree[b];
    }
    std::size_t sum = 0;
    for (std::size_t v = 0; v < size; ++v) {
      begin[v] = sum;
      sum += static_cast<std::size_t>(degree[v]);
    }
    std::vector<int> ends(std::max<std::size_t>(1, sum));
    std::vector<std::size_t> next = begin;
    for (const auto& [a, b] : graph.edges) {
      ends[next[a]++] = static_cast<int>(b);
      ends[next[b]++] = static_cast<int>(a);
    }
    sparsegraph sparse;
    SG_INIT(sparse);
    sparse.nde = sum;
    sparse.v = begin.data();
    sparse.nv = static_cast<int>(size);
    sparse.d = degree.data();
    sparse.e = ends.data();
    sparse.vlen = sparse.dlen = size;
    sparse.elen = ends.size();

    // Vertices by colour; a 0 ends each class.
    std::vector<int> in_order(size);
    std::iota(in_order.begin(), in_order.end(), 0);
    std::ranges::stable_sort(in_order, {}, [&](int v) { return graph.colours[std::size_t(v)]; });
    std::vector<int> goes_on(size, 0);
    for (std::size_t i = 0; i + 1 < size; ++i)
      goes_on[i] =
          graph.colours[std::size_t(in_order[i])] == graph.colours[std::size_t(in_order[i + 1])];
    std::vector<int> orbits(size);
    DEFAULTOPTIONS_SPARSEGRAPH(options);
    options.defaultptn = FALSE;
    options.userautomproc = note_generator;
    options.userlevelproc = note_level;
    statsblk statistics;
    found = &all;
    sparsenauty(&sparse, in_order.data(), goes_on.data(), orbits.data(), &options, &statistics,
                nullptr);
    found = nullptr;
    nausparse_freedyn();
    nautil_freedyn();
    nauty_freedyn();
    return all;
  }
};

}  // namespace
}  // namespace orasp

extern "C" __attribute__((visibility("default"))) orasp::AutomorphismFinder*
orasp_make_automorphism_finder_1() {
  return new orasp::NautyFinder();
}
