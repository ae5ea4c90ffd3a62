// One vehicle whose samples come on the standard input, a line each of time, east, north, speed, heading,
// acceleration and yaw rate; prints the octets that it sends as hexadecimal digits, a line a message.

#include <cstdio>
#include <cstdlib>

#include "modelcast_client.hpp"

int main(int, char** arguments) {
    modelcast::Settings settings;
    settings.sender = arguments[2];
    settings.seed = std::strtol(arguments[3], nullptr, 10);
    settings.latitude_deg = 48.0, settings.longitude_deg = 11.5;
    modelcast::Client client = modelcast::Client::at_socket(arguments[1], settings);
    double t_s, east_m, north_m, speed, heading, acceleration, yaw_rate;
    while (std::scanf("%lf %lf %lf %lf %lf %lf %lf", &t_s, &east_m, &north_m, &speed, &heading, &acceleration,
                      &yaw_rate) == 7) {
        modelcast::Step step;
        step.t_s = t_s, step.vehicle = {3}, step.position_m = {east_m, north_m}, step.speed_mps = {speed};
        step.heading_rad = {heading}, step.acceleration_mps2 = {acceleration}, step.yaw_rate_radps = {yaw_rate};
        for (const modelcast::Octets& one : client.step(step).frames()) {
            for (const std::uint8_t octet : one) std::printf("%02x", octet);
            std::printf("\n");
        }
    }
    try {
        client.step(modelcast::Step());  // of a time that has been
    } catch (const modelcast::Refused& error) {
        std::printf("%s %d\n", error.field.c_str(), error.ends);
    }
    return 0;
}
