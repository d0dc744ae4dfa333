#include "apps/play/live/remote/live_remote.h"

#include <algorithm>
#include <array>

#include "apps/play/live/remote/live_picture.h"
#include "engine/core/index.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {
namespace {

constexpr std::chrono::milliseconds kMeterInterval{50};
constexpr std::size_t kMostRequests = 16;

/// At most what fits, without half a character of UTF-8.
void copy_text(const std::string& text, char (&to)[200]) {
  auto bytes = std::min(text.size(), sizeof to - 1);
  while (bytes < text.size() && bytes > 0 && (static_cast<unsigned char>(text[bytes]) & 0xc0) == 0x80)
    --bytes;
  std::copy_n(text.begin(), bytes, to);
  to[bytes] = '\0';
}

const char* text_of(StreamState state) {
  switch (state) {
    case StreamState::Running:
      return "running";
    case StreamState::Lost:
      return "lost";
    case StreamState::Stalled:
      return "stalled";
    default:
      return "stopped";
  }
}

}  // namespace

RemoteUnit remote_unit(const Unit& unit) {
  static constexpr std::array kNames = {
      "dB",   "cents", "semitones", "%",   "us",    "ms",   "s",    "min", "um",      "mm",  "cm",   "m",
      "mm/s", "m/s",   "m/s^2",     "mg",  "g",     "kg",   "mN",   "N",   "kN",      "N/m", "N/mm", "N s/m",
      "Hz",   "kHz",   "rpm",       "bpm", "rad/s", "deg",  "rad",  "mJ",  "J",       "mW",  "W",    "mA",
      "A",    "mV",    "V",         "ohm", "kohm",  "Mohm", "mN m", "N m", "N m/rad", "T m", "kg/s", "uF"};
  if (unit.dimension.plain() && unit.dimension.radian == 0 && unit.factor == 1.0 && !unit.decibel)
    return {"", unit};
  for (const auto* name : kNames) {
    const auto known = parse_unit(name);
    if (known && known->dimension == unit.dimension && known->dimension.radian == unit.dimension.radian &&
        known->factor == unit.factor && known->decibel == unit.decibel)
      return {name, unit};
  }
  return {to_string(unit.dimension), {unit.dimension}};
}

LiveRemote::LiveRemote(Session& session, Performer& performer, Hertz sample_rate, bool screens)
    : session_(session),
      performer_(performer),
      meter_(std::make_shared<LevelMeter>(static_cast<int>(performer.inputs.size()),
                                          static_cast<int>(performer.outputs.size()))),
      guard_(performer.outputs.size() * kGuardStages),
      bodies_(performer.instrument(), performer.plant()),
      clock_(sample_rate),
      schedule_(sample_rate, *this) {
  session_.add_meter(meter_);
  session_.on_guard_event([this](const GuardEvent& event, const std::string& text) {
    push_event({.kind = RemoteEvent::Kind::Guard, .frame = event.frame}, text);
  });
  session_.on_edit([this](const std::vector<Error>& errors) {
    auto edit = std::make_shared<RemoteEdit>(RemoteEdit{errors});
    described_ = false;
    const std::lock_guard lock{mutex_};
    edit_ = std::move(edit);
  });
  performer.instrument().add_observer(watch_);
  follow_events();
  if (screens) scope_ = std::make_unique<LiveScope>(performer.instrument(), performer.plant());
  renew();
  described_ = false;  // the device is not known yet
}

LiveRemote::~LiveRemote() {
  (void)session_.stop();  // where an error ends the program it still plays
  session_.on_guard_event({});
  session_.on_edit({});
  player().remove_observer(watch_);
  judging_ = false;
}

// The network's side.

std::shared_ptr<const RemoteDescription> LiveRemote::description() const {
  const std::lock_guard lock{mutex_};
  return description_;
}

void LiveRemote::disarm() noexcept {
  auto& switches = session_.switches();
  if (switches.armed()) client_disarmed_ = true;
  switches.disarm();
}

void LiveRemote::mute(bool on) noexcept {
  auto& switches = session_.switches();
  if (switches.muted() != on) client_muted_ = true;
  switches.mute(on);
}

Result<int> LiveRemote::order_arm() {
  auto& switches = session_.switches();
  if (switches.armed() || switches.arm_ordered())
    return fail(Errc::BadArgument, "", "the drives are armed already", "disarm them first");
  const int arming = switches.disarms();
  keep_alive_.begin(Clock::now(), arming);
  switches.order_arm();
  return arming;
}

RemoteMeters LiveRemote::take_meters() {
  return {meter_->take_inputs(), meter_->take_outputs(), {guard_.begin(), guard_.end()}, load_};
}

void LiveRemote::watch(Clock::time_point now) noexcept {
  auto& switches = session_.switches();
  if (!keep_alive_.expired(now, switches.disarms())) return;
  switches.disarm();
  client_lost_ = true;
}

// The control thread's side.

void LiveRemote::tick(std::int64_t earliest) {
  follow_frames();
  follow_events();
  follow_bodies();
  if (session_.controls().version() != version_ || !described_) renew();
  if (scope_ && scope_->tick()) described_ = false;
  take_orders();
  if (session_.plays()) {
    session_.send_controls();
    const auto first_free = frame_ + 2 * std::int64_t{session_.granted().format.max_frames};
    schedule_.advance(clock_, frame_, std::max(first_free, earliest));
  }
  late_ = schedule_.late();
  publish_controls();
  report_states();
  publish_meters();
}

/// A reading of the clock in each new block.
void LiveRemote::follow_frames() {
  const auto frame = player().frame();
  const double now_s = system_seconds();
  if (frame < frame_) {
    clock_.restart();
    schedule_.restart();
  }
  if (std::exchange(frame_, frame) != frame) clock_.update(now_s, frame);
}

void LiveRemote::follow_events() {
  for (WatchedEvent event; watch_.take(event);)
    if (event.version == watched_version_)
      push_event({.kind = RemoteEvent::Kind::Trigger, .level = event.level, .frame = event.frame},
                 watched_[index(event.number)].name);
  if (player().version() == watched_version_) return;
  auto events = graph_events(player().plan());
  if (!watch_.choose(player().version(), events)) return;  // while no blocks come
  watched_version_ = player().version();
  watched_ = std::move(events);
  described_ = false;
}

void LiveRemote::follow_bodies() {
  if (bodies_.tick(Clock::now())) described_ = false;
  for (LiveBodies::Impact next; bodies_.take(next);)
    push_event({.kind = RemoteEvent::Kind::Impact,
                .value = next.world,
                .bodies = {next.impact.one, next.impact.other},
                .level = next.impact.speed,
                .frame = next.impact.frame},
               {});
}

void LiveRemote::take_orders() {
  // No more than the queue holds: a client may post as fast as they are taken.
  for (std::size_t taken = 0; taken < OrderQueue::kOrders && orders_.pop(bundle_); taken += bundle_.size()) {
    if (bundle_.size() == 1 && obey_at_once(bundle_.front())) continue;
    if (!schedule_.add(bundle_))
      messages_.emplace_back("too many changes of remote clients wait for their time: one was dropped");
  }
}

/// A change alone, without a time: the last one counts, as of keys.
bool LiveRemote::obey_at_once(const RemoteOrder& order) {
  using Kind = RemoteOrder::Kind;
  if (order.kind == Kind::Arm) return arm(order), true;
  if (order.kind == Kind::Strike) return (void)performer_.strike(), true;
  if (order.kind != Kind::Set || order.time_s != RemoteOrder::kNow || order.ramp_s > 0) return false;
  schedule_.end_ramp(order.number);
  (void)session_.controls().set(name_of(order.number), order.value);
  measure(order);
  return true;
}

void LiveRemote::arm(const RemoteOrder& order) {
  if (Clock::now() - order.received > kArmWait) return not_armed("the program was busy for too long");
  if (!session_.has_drives()) return not_armed("there is no drive to arm");
  if (const auto armed = session_.arm(true); !armed) return not_armed(to_string(armed.error()));
  if (session_.armed()) messages_.emplace_back("drives armed by a remote client");
}

void LiveRemote::not_armed(const std::string& why) {
  session_.switches().disarm();
  messages_.push_back(why);
  push_event({.kind = RemoteEvent::Kind::NotArmed}, why);
}

void LiveRemote::measure(const RemoteOrder& order) {
  const double ms = std::chrono::duration<double, std::milli>{Clock::now() - order.received}.count();
  ++delay_.changes;
  delay_.mean_ms += (ms - delay_.mean_ms) / static_cast<double>(delay_.changes);
  delay_.longest_ms = std::max(delay_.longest_ms, ms);
}

const std::string& LiveRemote::name_of(int number) const {
  static const std::string none;
  const auto& names = player().control_names();
  return number >= 0 && number < std::ssize(names) ? names[index(number)] : none;
}

std::optional<ScheduledControl> LiveRemote::control(int number) const {
  const auto* live = session_.controls().find(name_of(number));
  if (live == nullptr || live->frozen) return std::nullopt;
  const auto& control = live->control;
  return ScheduledControl{control.value, control.range.low, control.range.high, control.smooth_s,
                          control.unit.decibel};
}

void LiveRemote::note(int number, double value) { session_.controls().note(name_of(number), value); }

/// After an edit.
void LiveRemote::renew() {
  version_ = session_.controls().version();
  const auto& live = session_.controls().all();
  auto next = std::make_shared<RemoteDescription>(RemoteDescription{performer_.name,
                                                                    std::vector<RemoteControl>(live.size()),
                                                                    performer_.gestures(),
                                                                    performer_.inputs,
                                                                    performer_.outputs,
                                                                    {}});
  for (std::size_t stage = 0; stage < kGuardStages; ++stage)
    next->guard_stages.emplace_back(tactus::name_of(GuardStage::Index{stage}));
  for (std::size_t c = 0; c < live.size(); ++c) {
    auto& control = next->controls[c];
    const auto& planned = live[c].control;
    const auto [unit_name, unit] = remote_unit(planned.unit);
    control.name = planned.name;
    control.number = player().control_index(planned.name);
    control.unit_name = unit_name;
    control.unit = unit;
    control.about = planned.about;
    control.low = planned.range.low;
    control.high = planned.range.high;
    control.constant = live[c].frozen;
    control.value = planned.value;
    const int in_file = player().plan().control_index(planned.name);
    control.initial = in_file < 0 ? planned.value : player().plan().controls[index(in_file)].control.value;
  }
  for (auto& control : next->controls) {
    if (const auto source = midi_.find(control.name); source != midi_.end()) control.midi = source->second;
    if (const auto osc = std::ranges::find(osc_, control.name, &RigOsc::control); osc != osc_.end())
      control.osc = osc->address;
    const auto hid = std::ranges::find(hid_, control.name, &RigHid::control);
    if (hid != hid_.end()) control.hid = *hid;
  }
  next->presets = presets_;
  next->worlds = bodies_.worlds();
  if (const auto delay = performer_.world_delay()) next->world_delay_s = delay->value;
  for (const auto& event : watched_) next->events.push_back(event.name);
  if (scope_) draw(*next);
  described_ = true;
  const std::lock_guard lock{mutex_};
  description_ = std::move(next);
}

/// The files are read on a thread of their own: a disk may be slow.
void LiveRemote::draw(RemoteDescription& description) {
  auto picture = make_picture(performer_, *scope_);
  if (session_.opened()) {
    const auto& granted = session_.granted();
    picture.device = granted.device;
    picture.sample_rate_hz = granted.format.sample_rate.value;
    picture.block = granted.format.max_frames;
  }
  if (latency_) picture.latency_s = latency_->value;
  picture.latency_measured = latency_measured_;
  picture.files = files_;
  description.picture = std::make_shared<Picture>(std::move(picture));
  if (!files_read_.valid())
    files_read_ = std::async(std::launch::async, [files = performer_.files] { return read_files(files); });
}

void LiveRemote::publish_files() {
  if (!files_read_.valid() || files_read_.wait_for(std::chrono::seconds{0}) == std::future_status::timeout)
    return;
  auto files = files_read_.get();
  if (files == files_) return;
  files_ = std::move(files);
  described_ = false;
}

std::shared_ptr<const RemoteVerdict> LiveRemote::verdict() const {
  const std::lock_guard lock{mutex_};
  return verdict_;
}

void LiveRemote::order_verdict(double delay_s) {
  const std::lock_guard lock{mutex_};
  verdict_order_ = delay_s;
}

/// On a thread of its own: it takes seconds. A new order ends the one before.
void LiveRemote::follow_verdict() {
  const std::lock_guard lock{mutex_};
  if (judged_.valid()) {
    if (verdict_order_) judging_ = false;
    if (judged_.wait_for(std::chrono::seconds{0}) == std::future_status::timeout) return;
    auto verdict = judged_.get();
    if (judging_) verdict_ = std::make_shared<RemoteVerdict>(std::move(verdict));
  }
  if (!verdict_order_) return;
  std::map<std::string, ControlValue> controls;
  for (const auto& live : session_.controls().all()) controls[live.control.name] = live.control.value;
  judging_ = true;
  judged_ = std::async(std::launch::async, [this, controls, delay_s = *std::exchange(verdict_order_, {})] {
    auto verdict = performer_.judge(Seconds{delay_s}, controls, [this] { return judging_.load(); });
    return RemoteVerdict{delay_s, verdict.stable, std::move(verdict.text)};
  });
}

void LiveRemote::report(std::string text) {
  const std::lock_guard lock{mutex_};
  if (reports_.size() < kMostRequests) reports_.push_back(std::move(text));
}

bool LiveRemote::request(RemoteRequest request) {
  const std::lock_guard lock{mutex_};
  if (requests_.size() >= kMostRequests) return false;
  requests_.push_back(std::move(request));
  return true;
}

std::vector<RemoteRequest> LiveRemote::take_requests() {
  const std::lock_guard lock{mutex_};
  return std::exchange(requests_, {});
}

void LiveRemote::set_presets(std::vector<std::string> names) {
  presets_ = std::move(names);
  described_ = false;
}

void LiveRemote::set_sources(std::map<std::string, std::string> midi, std::vector<RigOsc> osc,
                             std::vector<RigHid> hid) {
  midi_ = std::move(midi);
  osc_ = std::move(osc);
  hid_ = std::move(hid);
  described_ = false;
}

bool LiveRemote::learn_hid(const RigHid& source) {
  return learning_.exchange(false) &&
         request({.kind = RemoteRequest::Kind::LearntHid, .name = {}, .hid = source});
}

bool LiveRemote::learn_address(const std::string& address) {
  return learning_.exchange(false) && request({RemoteRequest::Kind::LearntAddress, address});
}

void LiveRemote::apply(const Preset& preset, Seconds ramp) {
  std::vector<RemoteOrder> bundle;
  for (const auto& [name, value] : preset.values)
    bundle.push_back({.number = player().control_index(name),
                      .value = value,
                      .ramp_s = ramp.value,
                      .received = Clock::now()});
  if (!schedule_.add(bundle)) messages_.emplace_back("too many changes wait: the preset is not applied");
}

void LiveRemote::publish_state() {
  auto next = std::make_shared<RemoteState>();
  const auto health = session_.health();
  next->frame = frame_;
  next->time_s = clock_.known() ? clock_.time_of(static_cast<double>(frame_)) : system_seconds();
  next->drives = session_.has_drives();
  next->stream = text_of(session_.state());
  next->load = health.high_load;
  next->worst_load = health.peak_load;
  next->xruns = health.xruns;
  next->lost_frames = health.lost_frames;
  for (const auto& fault : player().faults()) next->faults.emplace_back(fault.path, fault.count);
  for (int c = 0; c < static_cast<int>(performer_.outputs.size()); ++c) {
    const auto use = session_.guard_use(c);
    next->coil.push_back(use.coil);
    next->body.push_back(use.body);
    next->excursion.push_back(use.excursion);
  }
  next->signals = scope_->levels();
  const std::lock_guard lock{mutex_};
  state_ = std::move(next);
}

std::shared_ptr<const RemoteState> LiveRemote::state() const {
  const std::lock_guard lock{mutex_};
  return state_;
}

std::shared_ptr<const RemoteEdit> LiveRemote::edit() const {
  const std::lock_guard lock{mutex_};
  return edit_;
}

void LiveRemote::order_scope(std::uint32_t id, int bin, std::vector<std::string> signals) {
  if (scope_) scope_->order(id, bin, std::move(signals));
}

void LiveRemote::order_levels(bool on) {
  if (scope_) scope_->order_levels(on);
}

/// Keys and MIDI move controls too.
void LiveRemote::publish_controls() {
  const auto& live = session_.controls().all();
  const auto& controls = description_->controls;
  for (std::size_t c = 0; c < std::min(live.size(), controls.size()); ++c)
    controls[c].value.store(live[c].control.value, std::memory_order_relaxed);
}

void LiveRemote::report_states() {
  {
    const std::lock_guard lock{mutex_};
    messages_.insert(messages_.end(), reports_.begin(), reports_.end());
    reports_.clear();
  }
  if (client_lost_.exchange(false))
    messages_.emplace_back("drives disarmed: the remote client that had armed them was silent for 0.5 s");
  if (client_disarmed_.exchange(false)) messages_.emplace_back("drives disarmed by a remote client");
  if (client_muted_.exchange(false))
    messages_.emplace_back(session_.muted() ? "muted by a remote client" : "unmuted by a remote client");
  for (auto [kind, before, now] : {std::tuple{RemoteEvent::Kind::Armed, &armed_before_, session_.armed()},
                                   {RemoteEvent::Kind::Muted, &muted_before_, session_.muted()}})
    if (std::exchange(*before, now) != now) push_event({.kind = kind, .value = now ? 1 : 0}, {});
}

/// The guards themselves are replaced when a device returns.
void LiveRemote::publish_meters() {
  const auto now = Clock::now();
  if (now - meters_read_ < kMeterInterval) return;
  meters_read_ = now;
  load_ = session_.high_load();
  if (scope_) {
    publish_files();
    publish_state();
    follow_verdict();
  }
  for (std::size_t c = 0; c < performer_.outputs.size(); ++c) {
    const auto counts = session_.guard_counts(static_cast<int>(c));
    for (std::size_t stage = 0; stage < kGuardStages; ++stage)
      guard_[c * kGuardStages + stage] = static_cast<double>(counts[stage].frames);
  }
}

/// Where no client takes them, the oldest are kept.
void LiveRemote::push_event(RemoteEvent event, const std::string& text) {
  if (event.frame == 0) event.frame = frame_;
  event.time_s = clock_.known() ? clock_.time_of(static_cast<double>(event.frame)) : system_seconds();
  copy_text(text, event.text);
  (void)events_.push(event);
}

}  // namespace tactus::app
