#include "orasp/learning/detail/observed_columns.h"

#include <algorithm>

#include "orasp/model/detail/rules.h"
#include "orasp/model/error.h"

namespace orasp::detail {

ObservedColumns::ObservedColumns(const TransitionSystem& system)
    : system_(system), size_(system.num_connections()) {
  const ContextLayout& layout = system.rules().context;
  for (std::size_t i = 0; i < layout.radix.size(); ++i) {
    const AttributeValues& attribute = system.rules().totals.attributes[i];
    context_.push_back({attribute.name, attribute.values, layout.stride[i]});
  }
  if (layout.place_stride != 0) {
    Context& places = context_.emplace_back();
    places.name = "place";
    places.stride = layout.place_stride;
    for (std::size_t i = 1; i <= layout.places.size(); ++i)
      places.values.push_back(std::to_string(i));
  }
  for (const Context& context : context_) size_ += context.values.size();
}

std::string ObservedColumns::name(std::size_t column) const {
  if (column < system_.num_connections())
    return "open " + system_.problem().connection_id(static_cast<ConnectionIndex>(column));
  column -= system_.num_connections();
  for (const Context& context : context_) {
    if (column < context.values.size()) return context.name + " " + context.values[column];
    column -= context.values.size();
  }
  throw InputError("an observation has " + std::to_string(size_) + " columns");
}

void ObservedColumns::collect(SetView state, std::vector<std::uint64_t>& columns) const {
  const SetView open = system_.open(state);
  columns.assign(words_for(size_), 0);
  std::ranges::copy(open, columns.begin());
  for_each_of_context(state, [&](std::size_t column) {
    columns[column / 64] |= std::uint64_t{1} << (column % 64);
  });
}

}  // namespace orasp::detail
