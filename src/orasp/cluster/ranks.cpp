// Finds and loads the module that holds MPI, and joins the ranks. No MPI here.
#include "orasp/cluster/ranks.h"

#include <charconv>
#include <cstdlib>
#include <string_view>

#include "orasp/containers/module_loader.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

constexpr detail::Module kModule = {
    .file = "orasp_mpi.so",
    .symbol = "orasp_join_ranks_3",
    .method = "the work",
    .absent =
        "cannot be shared by several processes in this build, which was made without MPI: "
        "install the packages libopenmpi-dev and openmpi-bin and build again",
    .unloadable = "the module with MPI cannot be loaded",
    .packages = "libopenmpi-dev and openmpi-bin"};

using Join = Ranks* (*)();

std::optional<std::size_t> number_in(const char* name) {
  const char* const text = std::getenv(name);
  if (text == nullptr) return std::nullopt;
  const std::string_view view(text);
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), number);
  if (error != std::errc() || end != view.data() + view.size()) return std::nullopt;
  return number;
}

}  // namespace

Launch launch_of_environment() {
  struct Names {
    const char* size;
    const char* rank;
    const char* only_with;
  };
  constexpr Names kLaunchers[] = {{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK", nullptr},
                                  {"PMI_SIZE", "PMI_RANK", nullptr},
                                  {"SLURM_NTASKS", "SLURM_PROCID", "PMIX_RANK"}};
  for (const Names& names : kLaunchers) {
    if (names.only_with != nullptr && std::getenv(names.only_with) == nullptr) continue;
    const auto size = number_in(names.size);
    const auto rank = number_in(names.rank);
    if (size && rank && *size > 1 && *rank < *size) return {.size = *size, .rank = *rank};
  }
  return {};
}

std::optional<std::string> ranks_obstacle() {
  return detail::module_obstacle(kModule);
}

std::unique_ptr<Ranks> join_ranks(const std::string& program) {
  const Launch launch = launch_of_environment();
  const auto join = reinterpret_cast<Join>(detail::load_module(kModule));
  std::unique_ptr<Ranks> ranks(join());
  if (ranks->size() != launch.size)
    throw InputError(std::to_string(launch.size) + " processes were started and MPI joined " +
                     std::to_string(ranks->size()) +
                     ": they were started by the mpirun of another MPI than Open MPI, or by srun "
                     "without --mpi=pmix");
  std::string fault;
  const std::vector<std::string> programs = ranks->gather(program);
  for (std::size_t rank = 1; rank < programs.size() && fault.empty(); ++rank) {
    if (programs[rank] != program)
      fault = "rank " + std::to_string(rank) + " runs \"" + programs[rank] + "\", and rank 0 \"" +
              program + "\": all ranks must run the same";
  }
  fault = ranks->broadcast(std::move(fault), 0);
  if (!fault.empty()) throw InputError(fault);
  return ranks;
}

}  // namespace orasp
