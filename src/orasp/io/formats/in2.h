#pragma once

#include <string_view>

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// The .IN2 files of assembly line balancing: the number n of tasks; n task times, one a line;
/// direct precedence relations "i,j", one a line; "-1,-1" at the end, which may be missing.
/// Each task becomes a connection of a part of its own to the part "base", with the task's time as
/// its duration; "i,j" becomes: j is handled after i. So the legal orders of the problem are the
/// orders of the precedence graph, and a plan's disassembly is an order of the tasks. Stations and
/// cycle times stand in no such file and mean nothing here.
/// Reference. Scholl (1993), Data of assembly line balancing problems, Schriften zur Quantitativen
/// Betriebswirtschaftslehre 16/93, TH Darmstadt.
/// @throws InputError with the line of the first fault.
[[nodiscard]] Converted read_in2(std::string_view text);

}  // namespace orasp
