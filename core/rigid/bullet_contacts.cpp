#include "core/rigid/bullet_contacts.h"

namespace loomstone {

void meet(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
  const auto shape = [](const btBroadphaseProxy* proxy) {
    return static_cast<const btCollisionObject*>(proxy->m_clientObject)->getCollisionShape();
  };
  btDispatcherInfo chosen = info;
  const auto flat = [](const btCollisionShape* s) { return s->isConcave() || s->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE; };
  chosen.m_enableSatConvex = !flat(shape(pair.m_pProxy0)) && !flat(shape(pair.m_pProxy1));
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, chosen);
}

}  // namespace loomstone
