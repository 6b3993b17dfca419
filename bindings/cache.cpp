// Binds the readers and writers of frame and checkpoint files.
#include "bindings/bindings.h"
#include "core/base/message.h"
#include "core/cache/checkpoint_file.h"
#include "core/cache/frame_file.h"

namespace loomstone {

namespace {

py::dict arrays(const Checkpoint& checkpoint) {
  py::dict dict;
  for (const auto& [name, array] : checkpoint.arrays)
    dict[name.c_str()] = py::array_t<double>(
        std::vector<py::ssize_t>(array.shape.begin(), array.shape.end()), array.values.data());
  return dict;
}

py::dict bytes(const Checkpoint& checkpoint) {
  py::dict dict;
  for (const auto& [name, values] : checkpoint.bytes)
    dict[name.c_str()] = py::bytes(reinterpret_cast<const char*>(values.data()), values.size());
  return dict;
}

Checkpoint unpickled(const py::tuple& state) {
  Checkpoint checkpoint;
  for (const auto& [name, values] : state[0].cast<py::dict>()) {
    const auto array =
        py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(values);
    Checkpoint::Array& made = checkpoint.arrays[name.cast<std::string>()];
    made.shape.assign(array.shape(), array.shape() + array.ndim());
    made.values.assign(array.data(), array.data() + array.size());
  }
  for (const auto& [name, values] : state[1].cast<py::dict>()) {
    const auto text = values.cast<std::string>();
    checkpoint.bytes[name.cast<std::string>()].assign(text.begin(), text.end());
  }
  checkpoint.integers = state[2].cast<decltype(checkpoint.integers)>();
  checkpoint.texts = state[3].cast<decltype(checkpoint.texts)>();
  return checkpoint;
}

void bind_checkpoint(py::module_& m) {
  py::class_<Checkpoint> c(
      m, "Checkpoint",
      "An exact state of a simulation: arrays, bytes, integers and texts by name.");
  c.def_property_readonly("arrays", &arrays, "copies of the arrays by name");
  c.def_property_readonly("bytes", &bytes, "opaque data by name");
  c.def_readonly("integers", &Checkpoint::integers, "lists of integers by name");
  c.def_readonly("texts", &Checkpoint::texts, "texts by name");
  c.def(py::pickle(
      [](const Checkpoint& self) {
        return py::make_tuple(arrays(self), bytes(self), self.integers, self.texts);
      },
      &unpickled));
  c.def("__repr__", [](const Checkpoint& self) {
    const auto step = self.integers.find("step");
    return step == self.integers.end() ? formatted("Checkpoint({} arrays)", self.arrays.size())
                                       : formatted("Checkpoint({} arrays, step {})",
                                                   self.arrays.size(), step->second.at(0));
  });
  m.def("write_checkpoint", &write_checkpoint, py::arg("path"), py::arg("checkpoint"),
        "Writes a checkpoint to a temporary file, which is then renamed to `path`.");
  m.def("read_checkpoint", &read_checkpoint, py::arg("path"),
        "Reads a checkpoint. Raises CacheError with the reason if that fails.");
}

}  // namespace

void bind_cache(py::module_& m) {
  py::class_<FrameWriter> writer(m, "FrameWriter",
                                 "Writes run.vtkhdf (cloth) and bodies.vtkhdf into a directory. "
                                 "The files can be read at any time.");
  writer.def(py::init<const std::string&, const FrameTopology&, const std::string&, int>(),
             py::arg("directory"), py::arg("topology"), py::arg("metadata"),
             py::arg("compression") = 0);
  writer.def_static("reopen", &FrameWriter::reopen, py::arg("directory"), py::arg("after_time"),
                    "Continues existing files. Frames later than after_time [s] are removed.");
  writer.def("write", &FrameWriter::write, py::arg("frame"),
             py::call_guard<py::gil_scoped_release>());
  writer.def_property_readonly("n_frames", &FrameWriter::n_frames);

  py::class_<FrameReader> reader(m, "FrameReader",
                                 "Reads the frames of a run from its directory or its run.vtkhdf.");
  reader.def(py::init<const std::string&>(), py::arg("path"));
  reader.def_property_readonly("n_frames", &FrameReader::n_frames);
  reader.def_property_readonly("topology", &FrameReader::topology,
                               py::return_value_policy::reference_internal);
  reader.def_property_readonly("metadata", &FrameReader::metadata,
                               "arbitrary text; JSON in files written by loomstone");
  reader.def_property_readonly(
      "times", [](py::object self) { return view(self.cast<const FrameReader&>().times(), self); },
      "(frames) times [s]");
  reader.def("frame", &FrameReader::frame, py::arg("index"),
             py::call_guard<py::gil_scoped_release>());
  bind_checkpoint(m);
}

}  // namespace loomstone
