#include "hgros/c/params.h"

#include <optional>

#include "c/handles.hpp"
#include "c/watch.hpp"
#include "hgros/params/param_service.hpp"
#include "hgros/params/remote_params.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros::c {

// Those of this program, perhaps offered to others; or those of a session.
struct Params {
  std::unique_ptr<ParamServer> own;
  std::unique_ptr<ParamService> service;  // Ends before `own`.
  std::unique_ptr<RemoteParams> remote;

  void EndWaits() noexcept {
    if (remote) remote->EndWaits();
  }
};

}  // namespace hgros::c

struct hgros_params {
  std::shared_ptr<hgros::c::Life> life;  // Null without a session.
  std::shared_ptr<hgros::c::Held<hgros::c::Params>> held;
};

namespace hgros::c {
namespace {

// Throws ParamError where another session does not answer.
ParamView All(Params& params) {
  if (params.own) return params.own->Snapshot();
  RemoteParam<ParamView> all = params.remote->Snapshot();
  if (!all.ok()) throw ParamError(all.refusal);
  return *std::move(all);
}

ParamServer& Own(Params& params) {
  if (params.own) return *params.own;
  throw Error("These are the parameters of another session.", {}, "Call it on those of this program.");
}

template <class F>
hgros_status UseParams(hgros_params* params, F&& use) {
  return Guarded([&] {
    const auto held = Given(params, "params").held;
    return held->Use([&](Params& of) {
      try {
        use(of);
      } catch (const ParamError&) {
        if (held->stop().stop_requested())
          throw SessionClosed(kSessionClosed);  // Which is why another session was not reached.
        throw;
      }
      return hgros_status{HGROS_OK};
    });
  });
}

template <class T, class Out, class F>
hgros_status Get(hgros_params* params, const char* path, Out* value, F&& convert) {
  if (value != nullptr) *value = {};
  return UseParams(params, [&](Params& of) {
    Out& place = Given(value, "the place for the value");
    place = convert(All(of).Get<T>(Text(path, "path")));
  });
}

void Change(Params& of, const ParamChange& change) {
  const ParamResult result = of.own ? of.own->Change({change}) : of.remote->Change({change});
  if (!result.ok()) throw ParamError(result.refusal);
}

template <class T>
hgros_status Set(hgros_params* params, const char* path, const T& value) {
  return UseParams(params, [&](Params& of) { Change(of, ParamChange::Of(Text(path, "path"), value)); });
}

ParamNode NodeFrom(const yaml::Node& node) {
  switch (node.kind) {
    case yaml::Node::Kind::kNull: break;
    case yaml::Node::Kind::kText: return ParamNode::Text(node.text, node.quoted);
    case yaml::Node::Kind::kList: {
      std::vector<ParamNode> items;
      for (const yaml::Node* const item : node.items) items.push_back(NodeFrom(*item));
      return ParamNode::List(std::move(items));
    }
    case yaml::Node::Kind::kMap: {
      std::vector<std::pair<std::string, ParamNode>> entries;
      for (const auto& [key, value] : node.entries) entries.emplace_back(key->text, NodeFrom(*value));
      return ParamNode::Map(std::move(entries));
    }
  }
  return {};
}

ParamNode NodeFrom(std::string_view text, std::string_view path) {
  const auto document = yaml::Document::ParseValue(text, "the value of " + std::string(path));
  return NodeFrom(document.root());
}

template <class T>
void DeclareAs(ParamServer& server, std::string_view path, ParamNode fallback, ParamInfo info) {
  const ParamView view(std::make_shared<const ParamNode>(std::move(fallback)), ParamPath::Parse(path));
  (void)server.Declare<T>(path, view.as<T>(), std::move(info));
}

ParamInfo InfoFrom(const hgros_param_info* given) {
  const hgros_param_info of = OptionsFrom(given);
  ParamInfo info;
  info.description = TextOrNone(of.description);
  info.unit = TextOrNone(of.unit);
  if (of.has_least != 0) info.least = of.least;
  if (of.has_most != 0) info.most = of.most;
  for (std::size_t i = 0; i < of.choice_count; ++i) {
    info.choices.emplace_back(Text(*(&Given(of.choices, "choices") + i), "a choice"));
  }
  info.read_only = of.read_only != 0;
  return info;
}

// What the handle of a watch and its calls share. A callback may close the watch, and free `user` then.
struct Watched {
  ParamPath path;
  hgros_param_callback callback;
  std::shared_ptr<const User> user;
  std::shared_ptr<WatchCalls> calls;
};

void Tell(const Watched& watched, const ParamEvent& event) {
  for (const ParamPath& path : event.paths) {
    if (watched.calls->closed()) return;
    if (!path.Overlaps(watched.path)) continue;
    const ParamView value = event.after.At(path);
    const std::string yaml = value.exists() ? value.ToYaml() : std::string();
    watched.callback(watched.user->get(), path.ToString().c_str(), value.exists() ? yaml.c_str() : nullptr);
  }
}

}  // namespace
}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_params_open(hgros_session* session, const char* const* files, size_t count, hgros_params** params) {
  return c::Creating(params, [&] {
    hgros::ParamSources sources;
    for (size_t i = 0; i < count; ++i) {
      sources.files.emplace_back(c::Text(*(&c::Given(files, "files") + i), "a file"));
    }
    auto made = std::make_unique<c::Params>();
    if (session != nullptr) {
      (void)c::Opened(session);
      const auto log = [&to = session->session->log()](hgros::LogLevel level, std::string_view text) {
        to.Write(level, text);
      };
      made->own = std::make_unique<hgros::ParamServer>(std::move(sources), log);
      made->service = std::make_unique<hgros::ParamService>(*session->session, *made->own, std::string(), log);
    } else {
      made->own = std::make_unique<hgros::ParamServer>(std::move(sources));
    }
    auto held = std::make_shared<c::Held<c::Params>>(std::move(made));
    const auto life = session == nullptr ? nullptr : session->life;
    if (life) life->Add(held);
    return std::make_unique<hgros_params>(hgros_params{life, std::move(held)});
  });
}

hgros_status hgros_params_of(hgros_session* session, const char* name, int64_t timeout_ns, hgros_params** params) {
  return c::Creating(params, [&] {
    const hgros_session& on = c::Opened(session);
    if (timeout_ns <= 0) {
      throw c::InvalidArgument(
          "timeout_ns must be above 0: each function on parameters of another session waits for it.");
    }
    auto made = std::make_unique<c::Params>();
    made->remote = std::make_unique<hgros::RemoteParams>(
        *on.session, c::Text(name, "name"), c::Timeout(timeout_ns),
        [&to = on.session->log()](hgros::LogLevel level, std::string_view text) { to.Write(level, text); });
    auto held = std::make_shared<c::Held<c::Params>>(std::move(made));
    on.life->Add(held);
    return std::make_unique<hgros_params>(hgros_params{on.life, std::move(held)});
  });
}

hgros_status hgros_params_close(hgros_params* params) {
  if (params == nullptr) return HGROS_OK;
  return c::Closing(params->life.get(), *params->held, [&] { delete params; });
}

hgros_status hgros_params_declare(hgros_params* params, const char* path, int32_t kind, const char* fallback,
                                  const hgros_param_info* info) {
  return c::UseParams(params, [&](c::Params& of) {
    hgros::ParamServer& server = c::Own(of);
    const std::string_view at = c::Text(path, "path");
    hgros::ParamNode value = c::NodeFrom(c::Text(fallback, "fallback"), at);
    hgros::ParamInfo about = c::InfoFrom(info);
    switch (kind) {
      case HGROS_PARAM_BOOL: return c::DeclareAs<bool>(server, at, std::move(value), std::move(about));
      case HGROS_PARAM_INTEGER: return c::DeclareAs<std::int64_t>(server, at, std::move(value), std::move(about));
      case HGROS_PARAM_NUMBER: return c::DeclareAs<double>(server, at, std::move(value), std::move(about));
      case HGROS_PARAM_TEXT: return c::DeclareAs<std::string>(server, at, std::move(value), std::move(about));
      case HGROS_PARAM_NUMBERS:
        return c::DeclareAs<std::vector<double>>(server, at, std::move(value), std::move(about));
      default: throw c::InvalidArgument("There is no kind " + std::to_string(kind) + ". Use HGROS_PARAM_...");
    }
  });
}

hgros_status hgros_params_get_bool(hgros_params* params, const char* path, int32_t* value) {
  return c::Get<bool>(params, path, value, [](bool is) { return is ? 1 : 0; });
}
hgros_status hgros_params_get_integer(hgros_params* params, const char* path, int64_t* value) {
  return c::Get<std::int64_t>(params, path, value, [](std::int64_t is) { return is; });
}
hgros_status hgros_params_get_number(hgros_params* params, const char* path, double* value) {
  return c::Get<double>(params, path, value, [](double is) { return is; });
}
hgros_status hgros_params_get_text(hgros_params* params, const char* path, char** value) {
  return c::Get<std::string>(params, path, value, [](const std::string& is) { return c::NewText(is); });
}

hgros_status hgros_params_get(hgros_params* params, const char* path, char** yaml) {
  if (yaml != nullptr) *yaml = nullptr;
  return c::UseParams(params, [&](c::Params& of) {
    char*& place = c::Given(yaml, "the place for the value");
    const hgros::ParamView value = c::All(of).At(c::Text(path, "path"));
    if (!value.exists()) throw hgros::ParamError(value.path().ToString() + " is not set.");
    place = c::NewText(value.ToYaml());
  });
}

hgros_status hgros_params_set_bool(hgros_params* params, const char* path, int32_t value) {
  return c::Set(params, path, value != 0);
}
hgros_status hgros_params_set_integer(hgros_params* params, const char* path, int64_t value) {
  return c::Set(params, path, value);
}
hgros_status hgros_params_set_number(hgros_params* params, const char* path, double value) {
  return c::Set(params, path, value);
}
hgros_status hgros_params_set_text(hgros_params* params, const char* path, const char* value) {
  return c::UseParams(params, [&](c::Params& of) {
    c::Change(of, hgros::ParamChange::Of(c::Text(path, "path"), std::string(c::Text(value, "value"))));
  });
}
hgros_status hgros_params_set(hgros_params* params, const char* path, const char* yaml) {
  return c::UseParams(params, [&](c::Params& of) {
    const std::string at(c::Text(path, "path"));
    c::Change(of, {at, c::NodeFrom(c::Text(yaml, "yaml"), at)});
  });
}
hgros_status hgros_params_remove(hgros_params* params, const char* path) {
  return c::UseParams(params, [&](c::Params& of) {
    c::Change(of, {std::string(c::Text(path, "path")), std::nullopt});
  });
}
hgros_status hgros_params_save(hgros_params* params) {
  return c::UseParams(params, [](c::Params& of) { c::Own(of).Save(); });
}

hgros_status hgros_params_watch(hgros_params* params, const char* path, hgros_param_callback callback, void* user,
                                hgros_release release, hgros_watch** watch) {
  if (watch != nullptr) *watch = nullptr;
  return c::Guarded([&] {
    const auto kept =
        c::KeepUser(user, release, params == nullptr ? c::CallbackOf{} : c::CallbackOf{params->life, params->held});
    if (callback == nullptr) c::RefuseNull("callback");
    return c::UseParams(params, [&](c::Params& of) {
      hgros_watch*& place = c::Given(watch, "the place for the result");
      auto made = std::make_unique<hgros_watch>();
      const std::string_view at = c::Text(path, "path");
      const auto tell = [watched = c::Watched{hgros::ParamPath::Parse(at), callback, kept, made->calls},
                         life = params->life,
                         held = static_cast<const void*>(params->held.get())](const hgros::ParamEvent& event) {
        const c::InCallback inside(life.get());
        const c::InCallback inside_params(held);
        watched.calls->Run([&] { c::Tell(watched, event); });
      };
      if (of.own) made->watching.listening = of.own->OnChange(at, tell);
      if (of.remote) made->watching.subscription = of.remote->Watch(at, tell);
      place = made.release();
    });
  });
}
