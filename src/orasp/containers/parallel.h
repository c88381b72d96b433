#pragma once

#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace orasp::detail {

/// Runs work(0) ... work(threads - 1) at the same time and waits for all; work(0) runs on the
/// calling thread. The first exception (by number) is thrown again here.
template <class Work>
void run_parallel(std::size_t threads, Work&& work) {
  if (threads <= 1) {
    work(std::size_t{0});
    return;
  }
  std::vector<std::exception_ptr> errors(threads);
  const auto guarded = [&](std::size_t t) {
    try {
      work(t);
    } catch (...) {
      errors[t] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    others.reserve(threads - 1);
    for (std::size_t t = 1; t < threads; ++t) others.emplace_back(guarded, t);
    guarded(0);
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

/// The t-th of `threads` nearly equal shares of 0 .. size.
struct Share {
  std::size_t begin;
  std::size_t end;
};
[[nodiscard]] constexpr Share share_of(std::size_t size, std::size_t threads, std::size_t t) {
  return {size / threads * t + size % threads * t / threads,
          size / threads * (t + 1) + size % threads * (t + 1) / threads};
}

}  // namespace orasp::detail
