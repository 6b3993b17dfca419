#include "core/collision/broad_phase/embree_pairs.h"

#include <embree3/rtcore.h>

#include <memory>
#include <mutex>
#include <utility>

#include "core/base/message.h"

namespace loomstone {

namespace {

// Owns an Embree scene of boxes. Must be destroyed before its device.
struct BoxScene {
  RTCScene scene = nullptr;
  std::vector<Index> item;  // index of each primitive's box; empty boxes are left out

  BoxScene(RTCDevice device, const std::vector<Slabs>& all) : slabs(all) {
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].low[0] <= all[i].high[0]) item.push_back(static_cast<Index>(i));
    scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(item.size()));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  BoxScene(const BoxScene&) = delete;
  BoxScene& operator=(const BoxScene&) = delete;
  ~BoxScene() { rtcReleaseScene(scene); }

 private:
  static void bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& self = *static_cast<const BoxScene*>(arguments->geometryUserPtr);
    const Slabs& box = self.slabs[self.item[arguments->primID]];
    RTCBounds& out = *arguments->bounds_o;
    out.lower_x = box.low[0], out.lower_y = box.low[1], out.lower_z = box.low[2];
    out.upper_x = box.high[0], out.upper_y = box.high[1], out.upper_z = box.high[2];
  }

  const std::vector<Slabs>& slabs;
};

struct Reports {
  std::mutex lock;  // guards `pairs`: Embree may call report() from its own threads
  std::vector<std::pair<unsigned, unsigned>> pairs;
};

void report(void* user, RTCCollision* collisions, unsigned n) {
  auto& reports = *static_cast<Reports*>(user);
  const std::lock_guard<std::mutex> guard(reports.lock);
  for (unsigned i = 0; i < n; ++i)
    reports.pairs.emplace_back(collisions[i].primID0, collisions[i].primID1);
}

}  // namespace

void embree_pairs(const std::vector<Slabs>& a, const std::vector<Slabs>& b,
                  const std::function<void(Index, Index)>& visit) {
  const std::unique_ptr<RTCDeviceTy, void (*)(RTCDevice)> device(rtcNewDevice("threads=1"),
                                                                 rtcReleaseDevice);
  if (!device)
    fail<Error>(
        "Embree could not create a device (error {}): there is not enough memory, or it does not "
        "support this processor",
        static_cast<int>(rtcGetDeviceError(nullptr)));
  const BoxScene first(device.get(), a), second(device.get(), b);
  if (first.item.empty() || second.item.empty()) return;
  Reports reports;
  rtcCollide(first.scene, second.scene, report, &reports);
  const RTCError error = rtcGetDeviceError(device.get());
  if (error != RTC_ERROR_NONE)
    fail<Error>("Embree failed with error {}; the usual cause is a lack of memory",
                static_cast<int>(error));
  for (const auto& [i, j] : reports.pairs) visit(first.item[i], second.item[j]);
}

}  // namespace loomstone
