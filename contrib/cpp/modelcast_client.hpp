// A client of modelcast's step protocol (docs/serve.md) in one header: C++17, POSIX sockets, nothing else.
//
//     modelcast::Client client = modelcast::Client::at_socket("/run/modelcast.sock", settings);
//     modelcast::Sent sent = client.step(step);
//
// Times are in seconds, lengths in metres, angles in radians clockwise from north. A comment behind a field
// is its type on the wire. modelcast::Refused tells what the server refuses; where its `ends` is false the
// session goes on. After any other error it has ended: BadAnswer is one that is not as the protocol says.

#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace modelcast {
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "arrays travel as little-endian numbers");

constexpr int kProtocol = 1;
constexpr std::uint32_t kFrameBytes = 33554432;
constexpr std::int64_t kForeign = -1;  // number of a message that the session did not send
enum class Kind : std::uint8_t { vehicle = 0, pedestrian = 1, cyclist = 2, road_worker = 3, roadside = 4 };
using Octets = std::vector<std::uint8_t>;

// The server refused a request: which field, what came, and what was expected.
struct Refused : std::runtime_error {
    explicit Refused(const std::string& text) : std::runtime_error(text) {}
    std::string field, value, expected;
    bool ends = false;
};

// The server's answer is not as the protocol says: which field, and what is wrong with it.
struct BadAnswer : std::runtime_error {
    BadAnswer(const std::string& field_, const std::string& wrong)
        : std::runtime_error("the server's answer is wrong: " + field_ + " " + wrong), field(field_) {}
    std::string field;
};

// What a session is begun with.
struct Settings {
    std::int64_t slots = 1, people_slots = 0, seed = 0, capacity = 500;             // integer
    double dt_s = 0.1, latitude_deg = 0.0, longitude_deg = 0.0, altitude_m = 0.0;   // number
    double minute_s = 0.0, spread_s = 0.0, threshold_m = 0.2, keep_alive_s = 1.0;   // number
    std::string sender = "mbc";                                                     // text
    template <class F> void each(F&& f) const {
        f("slots", slots), f("sender", sender), f("people_slots", people_slots), f("dt_s", dt_s);
        f("latitude_deg", latitude_deg), f("longitude_deg", longitude_deg), f("altitude_m", altitude_m);
        f("seed", seed), f("minute_s", minute_s), f("spread_s", spread_s), f("capacity", capacity);
        f("threshold_m", threshold_m), f("keep_alive_s", keep_alive_s);
    }
};

// All stations at one time, and what was received since the last step. An optional array that is empty is
// left out; of one with rows of several numbers the rows stand one after another.
struct Step {
    double t_s = 0.0;                                                               // number
    std::vector<std::uint32_t> vehicle;                                             // u4[N]
    std::vector<double> position_m;                                                 // f8[N,2]
    std::vector<double> speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps;  // f8[N]
    std::vector<double> busy_ratio;                                                 // f8[N]
    std::vector<std::uint8_t> kind, begins;                                         // u1[N]
    std::vector<std::uint32_t> receiver;                                            // u4[K]
    std::vector<double> received_s;                                                 // f8[K]
    std::vector<std::int64_t> message;                                              // i8[K]
    std::vector<std::uint32_t> foreign_length;                                      // u4[F]
    Octets foreign_octets;                                                          // octets
    template <class F> void each(F&& f) const {
        f("t_s", t_s), f("vehicle", vehicle), f("position_m", position_m), f.given("speed_mps", speed_mps);
        f.given("heading_rad", heading_rad), f.given("acceleration_mps2", acceleration_mps2);
        f.given("yaw_rate_radps", yaw_rate_radps), f.given("busy_ratio", busy_ratio), f.given("kind", kind);
        f.given("begins", begins), f.given("receiver", receiver), f.given("received_s", received_s);
        f.given("message", message), f.given("foreign_length", foreign_length);
        f.given("foreign_octets", foreign_octets);
    }
};

// What stations send until the next step, in order of time, and what became of the receptions.
struct Sent {
    double t_s = 0.0;                                                               // number
    std::vector<std::int64_t> message;                                              // i8[M]
    std::vector<std::uint32_t> vehicle, frame_bytes, length;                        // u4[M]
    std::vector<double> send_s, power_dbm, next_s;                                  // f8[M]
    std::vector<std::uint8_t> priority, grant, kind;                                // u1[M]
    Octets octets;                                                                  // octets
    std::vector<std::uint8_t> receipt;                                              // u1[K]
    std::vector<std::uint32_t> left;                                                // u4[L]
    template <class F> void each(F&& f) {
        f("t_s", t_s), f("message", message), f("vehicle", vehicle), f("send_s", send_s);
        f("frame_bytes", frame_bytes), f("power_dbm", power_dbm), f("priority", priority);
        f("next_s", next_s), f("grant", grant), f("kind", kind), f("length", length);
        f.alone("octets", octets), f.alone("receipt", receipt), f.alone("left", left);
    }
    // Octets of each message.
    std::vector<Octets> frames() const {
        std::vector<Octets> found;
        auto at = octets.begin();
        for (const std::uint32_t own : length) {
            if (own > octets.end() - at) throw std::runtime_error("length: more than the octets");
            found.emplace_back(at, at + own), at += own;
        }
        return found;
    }
};

// Local dynamic maps, host after host as asked, remotes by rising id.
struct Beliefs {
    double t_s = 0.0;                                                               // number
    std::vector<std::uint32_t> host, vehicle;                                       // u4[B]
    std::vector<double> position_m, velocity_mps;                                   // f8[B,2]
    std::vector<double> speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps;  // f8[B]
    std::vector<double> covariance_m2;                                              // f8[B,2,2]
    std::vector<double> information_age_s, received_s, length_m, width_m;           // f8[B]
    std::vector<std::uint8_t> kind;                                                 // u1[B]
    template <class F> void each(F&& f) {
        f("t_s", t_s), f("host", host), f("vehicle", vehicle), f("position_m", position_m, 2);
        f("velocity_mps", velocity_mps, 2), f("speed_mps", speed_mps), f("heading_rad", heading_rad);
        f("acceleration_mps2", acceleration_mps2), f("yaw_rate_radps", yaw_rate_radps);
        f("covariance_m2", covariance_m2, 4), f("information_age_s", information_age_s);
        f("received_s", received_s), f("kind", kind), f("length_m", length_m), f("width_m", width_m);
    }
};

// What safety applications say: pairs of host and remote with a level above none.
struct Warned {
    double t_s = 0.0;                                                               // number
    std::vector<std::uint32_t> host, vehicle;                                       // u4[W]
    std::vector<std::uint8_t> application, level;                                   // u1[W]
    std::vector<double> time_s, margin_m, certainty;                                // f8[W]
    template <class F> void each(F&& f) {
        f("t_s", t_s), f("host", host), f("vehicle", vehicle), f("application", application);
        f("level", level), f("time_s", time_s), f("margin_m", margin_m), f("certainty", certainty);
    }
};

template <class To, class From> To same_bits(From from) {
    To to;
    std::memcpy(&to, &from, sizeof to);
    return to;
}

// Writes one map of MessagePack: a type and fields.
class Writer {
public:
    explicit Writer(const char* type) { (*this)("type", std::string(type)); }
    template <class T> void operator()(const char* name, const T& value) {
        put(std::string(name)), put(value), ++fields_;
    }
    template <class T> void given(const char* name, const std::vector<T>& values) {
        if (!values.empty()) (*this)(name, values);
    }
    // The frame: length, map of so many fields, fields.
    Octets frame() const {
        Octets found = octets_;
        const auto length = static_cast<std::uint32_t>(found.size() - 4);
        std::memcpy(found.data(), &length, 4);
        found[5] = static_cast<std::uint8_t>(fields_ >> 8), found[6] = static_cast<std::uint8_t>(fields_);
        return found;
    }

private:
    void big(std::uint8_t head, std::uint64_t value, int octets) {
        octets_.push_back(head);
        while (octets--) octets_.push_back(static_cast<std::uint8_t>(value >> (8 * octets)));
    }
    void put(std::int64_t value) { big(0xd3, static_cast<std::uint64_t>(value), 8); }
    void put(double value) { big(0xcb, same_bits<std::uint64_t>(value), 8); }
    void put(const std::string& value) {
        big(0xdb, value.size(), 4);
        octets_.insert(octets_.end(), value.begin(), value.end());
    }
    void put(const std::vector<std::string>& values) {
        big(0xdd, values.size(), 4);
        for (const std::string& one : values) put(one);
    }
    template <class T> void put(const std::vector<T>& values) {
        const auto* first = reinterpret_cast<const std::uint8_t*>(values.data());
        big(0xc6, values.size() * sizeof(T), 4);
        octets_.insert(octets_.end(), first, first + values.size() * sizeof(T));
    }
    Octets octets_{0, 0, 0, 0, 0xde, 0, 0};
    unsigned fields_ = 0;
};

// Reads one map of MessagePack whose values are numbers, texts, flags and binaries. Each field is taken once;
// arrays have as many rows as the first, save those that are read alone.
class Reader {
public:
    explicit Reader(const Octets& octets) : at_(octets.data()), end_(octets.data() + octets.size()) {
        const std::uint8_t head = byte();
        std::uint64_t fields = head & 0x0f;
        if (head == 0xde) fields = big(2);
        else if ((head & 0xf0) != 0x80) throw BadAnswer("message", "is no map of MessagePack");
        while (fields--) {
            const Value name = value();
            const auto* text = std::get_if<std::string>(&name);
            if (!text || text->find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789") < text->size())
                throw BadAnswer("message", "has a field without a name");
            now_ = *text;
            if (!values_.emplace(now_, value()).second) throw BadAnswer(now_, "comes twice");
        }
        if (at_ != end_) throw BadAnswer("message", "goes on after its map");
    }
    template <class T> void operator()(const char* name, T& out) { out = take<T>(name); }
    template <class T> void operator()(const char* name, std::vector<T>& out, std::size_t row = 1) {
        alone(name, out, row);
        const std::size_t rows = out.size() / row;
        if (first_.empty()) first_ = name, rows_ = rows;
        if (rows != rows_) throw BadAnswer(name, "has not as many rows as " + first_);
    }
    template <class T> void alone(const char* name, std::vector<T>& out, std::size_t row = 1) {
        const Octets octets = take<Octets>(name);
        if (octets.size() % (row * sizeof(T))) throw BadAnswer(name, "ends within a row");
        out.resize(octets.size() / sizeof(T));
        if (!octets.empty()) std::memcpy(out.data(), octets.data(), octets.size());
    }

private:
    using Value = std::variant<double, bool, std::string, Octets>;
    template <class T> T take(const char* name) {
        auto found = values_.extract(name);
        if (found.empty()) throw BadAnswer(name, "is missing");
        T* value = std::get_if<T>(&found.mapped());
        if (!value) throw BadAnswer(name, "is of another type");
        return std::move(*value);
    }
    void need(std::uint64_t octets) const {
        if (static_cast<std::uint64_t>(end_ - at_) < octets) throw BadAnswer(now_, "is cut off");
    }
    std::uint8_t byte() { return static_cast<std::uint8_t>(big(1)); }
    std::uint64_t big(int octets) {
        need(static_cast<std::uint64_t>(octets));
        std::uint64_t found = 0;
        while (octets--) found = found << 8 | *at_++;
        return found;
    }
    template <class T> Value bytes(std::uint64_t count) {
        need(count), at_ += count;
        return T(at_ - count, at_);
    }
    Value value() {
        const std::uint8_t head = byte();
        if (head < 0x80) return static_cast<double>(head);
        if ((head & 0xe0) == 0xa0) return bytes<std::string>(head & 0x1f);
        switch (head) {
            case 0xc2: case 0xc3: return head == 0xc3;
            case 0xc4: case 0xc5: case 0xc6: return bytes<Octets>(big(1 << (head - 0xc4)));
            case 0xd9: case 0xda: case 0xdb: return bytes<std::string>(big(1 << (head - 0xd9)));
            case 0xcc: case 0xcd: case 0xce: case 0xcf: return static_cast<double>(big(1 << (head - 0xcc)));
            case 0xcb: return same_bits<double>(big(8));
            default: throw BadAnswer(now_, "is of a type that this protocol has not");
        }
    }
    const std::uint8_t* at_;
    const std::uint8_t* end_;
    std::map<std::string, Value> values_;
    std::string now_ = "message", first_;
    std::size_t rows_ = 0;
};

// A session; ends with its object, and where the server is silent for `silence_s` [s] (0: never). First steps
// may wait for compiled code.
class Client {
public:
    static Client at_socket(const std::string& path, const Settings& settings, std::uint32_t silence_s = 0) {
        sockaddr_un place{};
        if (path.size() >= sizeof place.sun_path) throw std::runtime_error("too long a path: " + path);
        place.sun_family = AF_UNIX, std::memcpy(place.sun_path, path.c_str(), path.size());
        return Client(reinterpret_cast<const sockaddr*>(&place), sizeof place, path, settings, silence_s);
    }
    static Client at_port(std::uint16_t port, const Settings& settings, std::uint32_t silence_s = 0) {
        sockaddr_in place{};
        place.sin_family = AF_INET, place.sin_port = htons(port);
        place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return Client(reinterpret_cast<const sockaddr*>(&place), sizeof place, "port " + std::to_string(port),
                      settings, silence_s);
    }
    Client(Client&& other) noexcept : socket_(std::exchange(other.socket_, -1)) { why_.swap(other.why_); }
    ~Client() { end(); }

    Sent step(const Step& step) {
        return ask<Sent>("step", "sent", [&](Writer& to) { step.each(to); }, [&](const Sent& sent) {
            among("vehicle", sent.vehicle, step.vehicle);
            std::uint64_t octets = 0;
            for (const std::uint64_t own : sent.length) octets += own;
            if (octets != sent.octets.size()) throw BadAnswer("length", "does not add up to the octets");
            if (sent.receipt.size() != step.receiver.size())
                throw BadAnswer("receipt", "is not one for each reception");
        });
    }
    Beliefs map(const std::vector<std::uint32_t>& host, double t_s) {
        return ask<Beliefs>("map", "beliefs", [&](Writer& to) { to("t_s", t_s), to("host", host); },
                            [&](const Beliefs& beliefs) { among("host", beliefs.host, host); });
    }
    Warned warnings(const std::vector<std::uint32_t>& host, const std::vector<std::string>& applications) {
        const auto fill = [&](Writer& to) { to("host", host), to("applications", applications); };
        return ask<Warned>("warnings", "warned", fill, [&](const Warned& warned) {
            among("host", warned.host, host);
            for (const std::size_t one : warned.application)
                if (one >= applications.size()) throw BadAnswer("application", "is none that was asked for");
        });
    }

private:
    struct Welcome {
        double protocol = 0.0;
        template <class F> void each(F&& f) { f("protocol", protocol); }
    };
    explicit Client(int socket) : socket_(socket) {}
    Client(const sockaddr* place, socklen_t size, const std::string& name, const Settings& given,
           std::uint32_t silence_s) : Client(::socket(place->sa_family, SOCK_STREAM, 0)) {
        const int on = 1;
        const timeval most{silence_s, 0};
        if (place->sa_family == AF_INET) ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        for (const int way : {SO_RCVTIMEO, SO_SNDTIMEO})
            ::setsockopt(socket_, SOL_SOCKET, way, &most, sizeof most);
        if (socket_ < 0 || ::connect(socket_, place, size) != 0)
            throw std::runtime_error("cannot reach the server at " + name + ": " + std::strerror(errno));
        const auto fill = [&](Writer& to) { to("protocol", std::int64_t{kProtocol}), given.each(to); };
        ask<Welcome>("hello", "welcome", fill, [](const Welcome& welcome) {
            if (welcome.protocol != kProtocol) throw BadAnswer("protocol", "is another version");
        });
    }
    void end() noexcept { if (socket_ >= 0) ::close(std::exchange(socket_, -1)); }
    // Ids in an answer are among those of the request.
    static void among(const char* field, const std::vector<std::uint32_t>& found,
                      std::vector<std::uint32_t> asked) {
        std::sort(asked.begin(), asked.end());
        for (const std::uint32_t one : found)
            if (!std::binary_search(asked.begin(), asked.end(), one))
                throw BadAnswer(field, std::to_string(one) + " was not in the request");
    }
    template <class Answer, class Fill, class Check>
    Answer ask(const char* type, const char* wanted, Fill&& fill, Check&& check) {
        if (socket_ < 0) throw std::runtime_error("the session has ended: " + why_);
        Writer to(type);
        fill(to);
        const Octets frame = to.frame();
        if (frame.size() - 4 > kFrameBytes) throw Refused("too long a message");
        try {
            for (std::size_t at = 0; at < frame.size();)
                at += moved(::send(socket_, frame.data() + at, frame.size() - at, MSG_NOSIGNAL));
            Answer answer = hear<Answer>(wanted);
            check(answer);
            return answer;
        } catch (const std::exception& error) {
            const auto* refused = dynamic_cast<const Refused*>(&error);
            if (!refused || refused->ends) end(), why_ = error.what();
            throw;
        }
    }
    Octets read(std::size_t count) {
        Octets found(count);
        for (std::size_t at = 0; at < count;) at += moved(::recv(socket_, found.data() + at, count - at, 0));
        return found;
    }
    static std::size_t moved(ssize_t octets) {
        if (octets > 0) return static_cast<std::size_t>(octets);
        if (octets < 0 && errno == EINTR) return 0;
        const bool late = octets < 0 && errno == EAGAIN;
        throw std::runtime_error(late ? "the server is silent" : "the server ended the session");
    }
    template <class Answer> Answer hear(const std::string& wanted) {
        const Octets head = read(4);
        const std::uint32_t length = head[0] | head[1] << 8 | head[2] << 16 | std::uint32_t{head[3]} << 24;
        if (length > kFrameBytes) throw BadAnswer("message", "has " + std::to_string(length) + " octets");
        Reader from(read(length));
        std::string kind, text;
        from("type", kind);
        if (kind == "error") {
            from("text", text);
            Refused refused(text);
            from("field", refused.field), from("value", refused.value);
            from("expected", refused.expected), from("ends", refused.ends);
            throw refused;
        }
        if (kind != wanted) throw BadAnswer("type", "is not " + wanted);
        Answer answer;
        answer.each(from);
        return answer;
    }
    int socket_;
    std::string why_ = "its object was moved";
};

}  // namespace modelcast
