#include <stdlib.h>
#include <string.h>

#include "addon.h"
#include "value.h"

static napi_value PeerFrom(napi_env napi, const hgros_peer* peer) {
  napi_value object = NULL;
  napi_create_object(napi, &object);
  Set(napi, object, "id", BigId(napi, peer->id));
  Set(napi, object, "process", Text(napi, peer->process));
  Set(napi, object, "host", Text(napi, peer->host));
  Set(napi, object, "pid", Number(napi, (double)peer->pid));
  Set(napi, object, "transport", Text(napi, peer->transport));
  Set(napi, object, "why", Text(napi, peer->why));
  return object;
}

// peers(session)
static napi_value Peers(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  napi_value array = NULL;
  hgros_peers* peers = NULL;
  hgros_peer peer = {.size = sizeof peer};
  Arguments(napi, info, 1, &argument);
  Part* const session = OpenPartOf(napi, argument, "The session is closed.");
  if (session == NULL) return NULL;
  const hgros_status status = hgros_peers_open(session->handle, &peers);
  if (status != HGROS_OK) return Checked(napi, status);
  napi_create_array(napi, &array);
  for (uint32_t i = 0; hgros_peers_get(peers, i, &peer) == HGROS_OK; ++i) {
    napi_set_element(napi, array, i, PeerFrom(napi, &peer));
  }
  hgros_peers_free(peers);
  return array;
}

static napi_value ChannelFrom(napi_env napi, const hgros_channel* channel) {
  napi_value object = NULL;
  napi_create_object(napi, &object);
  Set(napi, object, "name", Text(napi, channel->name));
  Set(napi, object, "typeName", Text(napi, channel->type_name));
  Set(napi, object, "fingerprint", BigId(napi, channel->fingerprint));
  Set(napi, object, "encoding", Number(napi, channel->encoding));
  Set(napi, object, "publishers", Number(napi, (double)channel->publishers));
  Set(napi, object, "subscribers", Number(napi, (double)channel->subscribers));
  return object;
}

// channels(session)
static napi_value Channels(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  napi_value array = NULL;
  hgros_channels* channels = NULL;
  hgros_channel channel = {.size = sizeof channel};
  Arguments(napi, info, 1, &argument);
  Part* const session = OpenPartOf(napi, argument, "The session is closed.");
  if (session == NULL) return NULL;
  const hgros_status status = hgros_channels_open(session->handle, &channels);
  if (status != HGROS_OK) return Checked(napi, status);
  napi_create_array(napi, &array);
  for (uint32_t i = 0; hgros_channels_get(channels, i, &channel) == HGROS_OK; ++i) {
    napi_set_element(napi, array, i, ChannelFrom(napi, &channel));
  }
  hgros_channels_free(channels);
  return array;
}

typedef struct {
  Arrival arrival;
  Part* watch;
  int32_t event;
  hgros_peer peer;  // With texts of its own.
  char* channel;
  char* reason;
} PeerEvent;

static void ShowPeerEvent(Env* env, Arrival* arrival) {
  PeerEvent* const event = (PeerEvent*)arrival;
  if (env != NULL && event->watch->callback != NULL) {
    const napi_value arguments[] = {Number(env->napi, event->event), PeerFrom(env->napi, &event->peer),
                                    Text(env->napi, event->channel), Text(env->napi, event->reason)};
    CallBack(env, event->watch->callback, 4, arguments);
  }
  ReleasePart(event->watch);
  free((char*)event->peer.process);
  free((char*)event->peer.host);
  free((char*)event->peer.transport);
  free((char*)event->peer.why);
  free(event->channel);
  free(event->reason);
  free(event);
}

static char* CopyOf(const char* text) { return strdup(text != NULL ? text : ""); }

// Any thread.
static void Happened(void* user, int32_t happened, const hgros_peer* peer, const char* channel, const char* reason) {
  Part* const watch = user;
  PeerEvent* const event = calloc(1, sizeof *event);
  event->arrival.run = ShowPeerEvent;
  event->watch = watch;
  event->event = happened;
  event->peer.id = peer->id;
  event->peer.pid = peer->pid;
  event->peer.process = CopyOf(peer->process);
  event->peer.host = CopyOf(peer->host);
  event->peer.transport = CopyOf(peer->transport);
  event->peer.why = CopyOf(peer->why);
  event->channel = CopyOf(channel);
  event->reason = CopyOf(reason);
  RetainPart(watch);
  Post(watch->env, &event->arrival);
}

static void CloseWatch(void* watch) { hgros_watch_close(watch); }

// watchPeers(session, happened)
static napi_value WatchPeers(napi_env napi, napi_callback_info info) {
  napi_value arguments[2];
  Part* part = NULL;
  hgros_watch* watch = NULL;
  Arguments(napi, info, 2, arguments);
  Part* const session = OpenPartOf(napi, arguments[0], "The session is closed.");
  if (session == NULL) return NULL;
  const napi_value value = NewPart(session->env, session, CloseWatch, arguments[1], &part);
  part->keeps_awake = true;
  const hgros_status status = hgros_watch_peers(session->handle, Happened, part, NULL, &watch);
  return Opened(part, watch, status, value);
}

// closeWatch(watch), of any kind
static napi_value CloseWatchNow(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  ClosePart(PartOf(napi, argument));
  return Undefined(napi);
}

void DefineObservation(napi_env napi, napi_value exports) {
  Define(napi, exports, "peers", Peers);
  Define(napi, exports, "channels", Channels);
  Define(napi, exports, "watchPeers", WatchPeers);
  Define(napi, exports, "closeWatch", CloseWatchNow);
}
