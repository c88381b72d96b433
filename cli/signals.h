#pragma once

#include <stop_token>

namespace orasp::cli {

/// To be called once, first of all: a closed pipe and a file that may not grow become errors of
/// write(), and descriptors 0 to 2 that the caller closed are taken, so that no file opened later
/// is mistaken for one of them.
void prepare_streams();

/// From now on the first SIGINT or SIGTERM requests a stop, so that the best plan so far can be
/// printed; the second ends the program at once. A signal that the caller had set to be ignored
/// (nohup, `&` in scripts) stays ignored.
///
/// Signals are taken by a thread that waits for them (sigwait), not by a handler: a stop may run
/// callbacks and take locks, which no handler may. Call it before other threads are started: they
/// inherit the blocked signals.
[[nodiscard]] std::stop_token stop_on_signals();

}  // namespace orasp::cli
