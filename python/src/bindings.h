#pragma once

#include <pybind11/pybind11.h>

/// What each file of this folder adds to the module orasp._orasp. The module is what the package
/// orasp/ is built on and is for nobody else: it takes and gives plain values, and checks what the
/// library checks.
namespace orasp::python {

void bind_problem(pybind11::module_& module);
void bind_solve(pybind11::module_& module);
void bind_environment(pybind11::module_& module);

}  // namespace orasp::python
