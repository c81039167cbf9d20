// Arrays of the library as those of NumPy, without a copy: each keeps alive what owns its memory.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "isopach/base/array.hpp"

namespace isopach::python {

namespace nb = nanobind;

template <class T>
nb::object view1(const T* data, std::size_t n, nb::handle owner, std::int64_t stride = 1) {
  const std::size_t shape[1] = {n};
  const std::int64_t strides[1] = {stride};
  return nb::cast(nb::ndarray<nb::numpy, const T>(data, 1, shape, owner, strides));
}
template <class T>
nb::object view2(const T* data, std::size_t n, std::size_t columns, nb::handle owner) {
  const std::size_t shape[2] = {n, columns};
  return nb::cast(nb::ndarray<nb::numpy, const T>(data, 2, shape, owner));
}

/// Arrays that are made on demand belong to the array that shows them.
template <class A>
nb::capsule owner_of(std::shared_ptr<A> array) {
  return nb::capsule(new std::shared_ptr<A>(std::move(array)),
                     [](void* p) noexcept { delete static_cast<std::shared_ptr<A>*>(p); });
}
template <class T>
nb::object given1(Array<T> values) {
  auto shared = std::make_shared<Array<T>>(std::move(values));
  const T* data = shared->data();
  const std::size_t n = shared->size();
  return view1(data, n, owner_of(std::move(shared)));
}

using InDoubles = nb::ndarray<const double, nb::device::cpu>;
using InMesh = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using InValues = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using InTriangles = nb::ndarray<const std::int32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

}  // namespace isopach::python
