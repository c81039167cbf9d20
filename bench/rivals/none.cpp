// Where no rival is installed: available() is false, and nothing else is called.
#include <stdexcept>

#include "bench/rivals/rival.hpp"

namespace isopach::bench::rival {
namespace {

[[noreturn]] void absent() { throw std::logic_error("no rival is built in"); }

}  // namespace

bool available() { return false; }
std::string name() { return "no rival"; }
std::shared_ptr<Input> input(std::span<const Point2>) { absent(); }
std::shared_ptr<Input> hilbert_sorted(std::span<const Point2>) { absent(); }
std::shared_ptr<Mesh> triangulate(const Input&) { absent(); }
std::shared_ptr<Mesh> copy(const Mesh&) { absent(); }
std::size_t edges(const Mesh&) { absent(); }
std::size_t locate(const Mesh&, const Input&) { absent(); }
void insert(Mesh&, const Input&) { absent(); }
Volume compare(std::span<const Point3>, std::span<const Point3>) { absent(); }

}  // namespace isopach::bench::rival
