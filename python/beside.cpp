#include "beside.hpp"

namespace isopach::python {
namespace {

PyObject* failure_type = nullptr;

}  // namespace

void make_failure_type(nb::module_& module) {
  failure_type = PyErr_NewException("isopach._core.Failure", PyExc_Exception, nullptr);
  module.attr("Failure") = nb::borrow(failure_type);
}

nb::str to_str(const std::string& text) {
  PyObject* made = PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape");
  if (made == nullptr) throw nb::python_error();
  return nb::steal<nb::str>(made);
}

std::string to_string(const nb::bytes& bytes) { return {bytes.c_str(), bytes.size()}; }

void raise_failure(ExitCode code, const std::string& message) {
  nb::object args = nb::make_tuple(static_cast<int>(code), to_str(message));
  PyErr_SetObject(failure_type, args.ptr());
  throw nb::python_error();
}

}  // namespace isopach::python
