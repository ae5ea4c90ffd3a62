// Lets Veins-style vehicles drive on the stub's event loop, with a radio that loses nothing, and prints what
// each sent and heard, and how far its map is off.

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "ModelcastApp.h"
#include "veins/modules/messages/PhyControlMessage_m.h"

namespace {

constexpr int kVehicles = 4, kFirstId = 11;
constexpr double kStep_s = 0.1, kDelay_s = 0.002;

struct Vehicle {
    omnetpp::cModule host;
    modelcast::ModelcastApp app;
    veins::Mobility mobility;
    int sent = 0, heard = 0;
    double most_mW = 0.0;
    explicit Vehicle(int id) : host(id) {}
};

}  // namespace

int main(int, char** arguments) {
    const double duration_s = std::strtod(arguments[2], nullptr);
    std::vector<std::unique_ptr<Vehicle>> vehicles;
    modelcast::Settings settings;
    settings.slots = kVehicles;
    const auto stations = modelcast::Stations::shared(arguments[1], settings);
    for (int one = 0; one < kVehicles; ++one) {
        vehicles.push_back(std::make_unique<Vehicle>(kFirstId + one));
        Vehicle& own = *vehicles.back();
        own.app.host = &own.host;
        own.app.parameters = {{"socket", arguments[1]}, {"sender", "mbc"}, {"slots", "4"},
                              {"stepLength", "0.1"}, {"seed", "0"}};
        own.app.initialize(0);
        own.app.to_mac = [&own, &vehicles](veins::BaseFrame1609_4* frame) {
            ++own.sent;
            const auto& power = dynamic_cast<veins::PhyControlMessage&>(*frame->getControlInfo());
            own.most_mW = std::max(own.most_mW, power.getTxPower_mW());
            for (const auto& other : vehicles) {
                if (other.get() == &own) continue;
                auto* copy = dynamic_cast<veins::BaseFrame1609_4*>(frame->dup());
                const double at_s = omnetpp::simTime().dbl() + kDelay_s;
                omnetpp::simulation().at(at_s, 0, [&other, copy] {
                    ++other->heard;
                    other->app.from_mac(copy);
                    delete copy;
                });
            }
            delete frame;
        };
    }
    const int steps = static_cast<int>(std::lround(duration_s / kStep_s));
    for (int step = 0; step < steps; ++step) {
        // As TraCI: all positions within one event. A mobility module may signal twice; its last word counts.
        omnetpp::simulation().at(kStep_s * step, 0, [&vehicles] {
            const double t_s = omnetpp::simTime().dbl();
            for (int one = 0; one < kVehicles; ++one) {
                veins::Mobility& own = vehicles[one]->mobility;
                const double omega = 0.2, radius_m = 60.0 + 5.0 * one;
                const double cosine = std::cos(omega * t_s), sine = std::sin(omega * t_s);
                own.position = {1000.0, 1000.0, 0.0};
                vehicles[one]->app.moved(own);
                own.position = {radius_m * cosine, radius_m * sine, 0.0};
                own.speed = {-radius_m * omega * sine, radius_m * omega * cosine, 0.0};
                vehicles[one]->app.moved(own);
            }
        });
    }
    omnetpp::simulation().run(duration_s);
    const double last_s = kStep_s * (steps - 1);
    for (int one = 0; one < kVehicles; ++one) {
        const modelcast::Beliefs map = stations->map(kFirstId + one, last_s);
        double worst_m = 0.0;
        for (std::size_t row = 0; row < map.vehicle.size(); ++row) {
            const veins::Coord& truth = vehicles[map.vehicle[row] - kFirstId]->mobility.position;
            worst_m = std::max(worst_m, std::hypot(map.position_m[2 * row] - truth.x,
                                                   map.position_m[2 * row + 1] + truth.y));
        }
        std::printf("%d %d %d %zu %.3f %.1f\n", kFirstId + one, vehicles[one]->sent, vehicles[one]->heard,
                    map.vehicle.size(), worst_m, vehicles[one]->most_mW);
    }
    return 0;
}
