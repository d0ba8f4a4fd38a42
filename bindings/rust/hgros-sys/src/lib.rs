//! The C interface of HyperGraph ROS (`hgros/hgros.h`), as far as the crate `hgros` uses it. The header documents each
//! function.
#![allow(non_camel_case_types)]

use std::os::raw::{c_char, c_void};

/// Types that only the library knows.
macro_rules! handles {
    ($($name:ident)*) => {$(
        #[repr(C)]
        pub struct $name {
            _private: [u8; 0],
            // Whether a handle may be sent or shared is said where it is used.
            _pointer: std::marker::PhantomData<*mut u8>,
        }
    )*};
}
handles! {
    hgros_session hgros_schema hgros_message hgros_publisher hgros_loan hgros_subscription hgros_service hgros_reply
    hgros_params hgros_transforms hgros_peers hgros_channels hgros_watch
}

pub type hgros_status = i32;

macro_rules! constants {
    ($($name:ident = $value:literal)*) => {
        $(pub const $name: i32 = $value;)*

        fn constant_lines() -> Vec<String> {
            vec![$(format!("constant {} {}", stringify!($name), $name)),*]
        }
    };
}
constants! {
    HGROS_OK = 0
    HGROS_INVALID_ARGUMENT = 1
    HGROS_ERROR = 2
    HGROS_TYPE_MISMATCH = 3
    HGROS_CONFIG_ERROR = 4
    HGROS_CLOSED = 5
    HGROS_FULL = 6
    HGROS_TIMED_OUT = 7
    HGROS_WOULD_DEADLOCK = 8
    HGROS_TOO_LARGE = 9
    HGROS_NO_MEMORY = 10
    HGROS_NOT_FOUND = 11
    HGROS_REFUSED = 12
    HGROS_NO_SERVER = 20
    HGROS_HANDLER_FAILED = 21
    HGROS_SERVER_GONE = 22
    HGROS_CANCELLED = 23
    HGROS_NOT_WRITABLE = 24
    HGROS_UNKNOWN_FRAME = 30
    HGROS_NOT_CONNECTED = 31
    HGROS_TOO_OLD = 32
    HGROS_TOO_NEW = 33

    HGROS_LOG_DEBUG = 0
    HGROS_LOG_INFO = 1
    HGROS_LOG_WARNING = 2
    HGROS_LOG_ERROR = 3

    HGROS_ENCODING_NONE = 0
    HGROS_ENCODING_PROTOBUF = 1
    HGROS_ENCODING_CUSTOM = 2
    HGROS_ENCODING_PLAIN = 3

    HGROS_EXECUTOR_WORKERS = 0
    HGROS_EXECUTOR_INLINE = 1
    HGROS_EXECUTOR_DEDICATED = 2

    HGROS_PARAM_BOOL = 0
    HGROS_PARAM_INTEGER = 1
    HGROS_PARAM_NUMBER = 2
    HGROS_PARAM_TEXT = 3
    HGROS_PARAM_NUMBERS = 4

    HGROS_PEER_CAME = 0
    HGROS_PEER_GONE = 1
    HGROS_PEER_TYPE_MISMATCH = 2
    HGROS_PEER_SERVED_TWICE = 3
}

// What the library calls. A panic must not leave them.
pub type hgros_release = unsafe extern "C" fn(user: *mut c_void);
pub type hgros_log_callback =
    unsafe extern "C" fn(user: *mut c_void, level: i32, text: *const c_char);
pub type hgros_message_callback =
    unsafe extern "C" fn(user: *mut c_void, message: *const hgros_message);
pub type hgros_service_handler =
    unsafe extern "C" fn(user: *mut c_void, request: *const hgros_message, reply: *mut hgros_reply);
pub type hgros_param_callback =
    unsafe extern "C" fn(user: *mut c_void, path: *const c_char, yaml: *const c_char);
pub type hgros_peer_callback = unsafe extern "C" fn(
    user: *mut c_void,
    event: i32,
    peer: *const hgros_peer,
    channel: *const c_char,
    reason: *const c_char,
);

/// Structs of the interface. Those that may grow begin with `size`, which is set to the size of the struct here.
macro_rules! structs {
    ($($name:ident { $($field:ident: $type:ty),* $(,)? })*) => {
        $(
            #[repr(C)]
            #[derive(Clone, Copy)]
            pub struct $name { $(pub $field: $type),* }

            impl $name {
                /// All zero, which is the default of every option.
                fn zero() -> Self {
                    // SAFETY: integers, floating-point numbers, pointers and optional functions may be zero.
                    unsafe { std::mem::zeroed() }
                }
            }
        )*

        fn struct_lines() -> Vec<String> {
            let mut lines = Vec::new();
            $(
                let one = $name::zero();
                let start = std::ptr::addr_of!(one) as usize;
                lines.push(format!("struct {} {}", stringify!($name), std::mem::size_of::<$name>()));
                $(
                    let offset = std::ptr::addr_of!(one.$field) as usize - start;
                    let size = std::mem::size_of_val(&one.$field);
                    lines.push(format!("field {}.{} {} {}", stringify!($name), stringify!($field), offset, size));
                )*
            )*
            lines
        }
    };
}
structs! {
    hgros_session_options {
        size: usize,
        name: *const c_char,
        log: Option<hgros_log_callback>,
        log_user: *mut c_void,
        log_release: Option<hgros_release>,
    }
    hgros_message_info {
        size: usize,
        remote: i32,
        publisher: u64,
        incarnation: u64,
        sequence: u64,
        key: u64,
        publish_monotonic_ns: i64,
        publish_time_ns: i64,
    }
    hgros_publish_options {
        size: usize,
        latched: u64,
    }
    hgros_subscribe_options {
        size: usize,
        name: *const c_char,
        schema: *const hgros_schema,
        keep_last: u64,
        keep_all: u64,
        keep_all_bytes: u64,
        concurrent: i32,
        executor: i32,
    }
    hgros_subscription_stats {
        size: usize,
        received: u64,
        dropped: u64,
        run: u64,
        queued: u64,
        mismatched: u64,
        queue_wait_p50_ns: i64,
        queue_wait_p99_ns: i64,
    }
    hgros_serve_options {
        size: usize,
        name: *const c_char,
        most_waiting: u64,
        concurrent: i32,
        executor: i32,
    }
    hgros_param_info {
        size: usize,
        read_only: i32,
        description: *const c_char,
        unit: *const c_char,
        has_least: i32,
        has_most: i32,
        least: f64,
        most: f64,
        choices: *const *const c_char,
        choice_count: usize,
    }
    hgros_transform {
        translation: [f64; 3],
        rotation: [f64; 4],
        stamp_ns: i64,
    }
    hgros_peer {
        size: usize,
        id: u64,
        process: *const c_char,
        host: *const c_char,
        pid: i64,
        transport: *const c_char,
        why: *const c_char,
    }
    hgros_channel {
        size: usize,
        name: *const c_char,
        type_name: *const c_char,
        fingerprint: u64,
        encoding: i32,
        publishers: usize,
        subscribers: usize,
    }
}

/// The constants and structs above in the words of tests/c/abi.txt, which has those of the header.
pub fn abi() -> Vec<String> {
    let mut lines = constant_lines();
    lines.extend(struct_lines());
    lines
}

impl Default for hgros_transform {
    fn default() -> Self {
        Self::zero()
    }
}

/// Structs that may grow: the default has their size.
macro_rules! sized {
    ($($name:ident)*) => {$(
        impl Default for $name {
            fn default() -> Self {
                Self { size: std::mem::size_of::<Self>(), ..Self::zero() }
            }
        }
    )*};
}
sized! {
    hgros_session_options hgros_message_info hgros_publish_options hgros_subscribe_options hgros_subscription_stats
    hgros_serve_options hgros_param_info hgros_peer hgros_channel
}

extern "C" {
    pub fn hgros_last_error() -> *const c_char;
    pub fn hgros_version() -> *const c_char;
    pub fn hgros_text_free(text: *mut c_char);

    pub fn hgros_session_open(
        yaml: *const c_char,
        options: *const hgros_session_options,
        session: *mut *mut hgros_session,
    ) -> hgros_status;
    pub fn hgros_session_open_files(
        files: *const *const c_char,
        count: usize,
        options: *const hgros_session_options,
        session: *mut *mut hgros_session,
    ) -> hgros_status;
    pub fn hgros_session_end(session: *mut hgros_session);
    pub fn hgros_session_close(session: *mut hgros_session);
    pub fn hgros_session_name(session: *const hgros_session) -> *const c_char;
    pub fn hgros_session_id(session: *const hgros_session) -> u64;
    pub fn hgros_session_wait_idle(session: *const hgros_session, timeout_ns: i64) -> hgros_status;
    pub fn hgros_session_log(
        session: *const hgros_session,
        level: i32,
        text: *const c_char,
    ) -> hgros_status;
    pub fn hgros_session_log_limited(
        session: *const hgros_session,
        level: i32,
        alike: *const c_char,
        text: *const c_char,
    ) -> hgros_status;
    pub fn hgros_session_set_log_level(session: *const hgros_session, level: i32) -> hgros_status;
    pub fn hgros_session_wait_for_subscribers(
        session: *const hgros_session,
        channel: *const c_char,
        count: usize,
        timeout_ns: i64,
    ) -> hgros_status;
    pub fn hgros_session_wait_for_publishers(
        session: *const hgros_session,
        channel: *const c_char,
        count: usize,
        timeout_ns: i64,
    ) -> hgros_status;

    pub fn hgros_schema_create(
        type_name: *const c_char,
        encoding: i32,
        fingerprint: u64,
        descriptor_set: *const c_void,
        descriptor_set_size: usize,
        schema: *mut *mut hgros_schema,
    ) -> hgros_status;
    pub fn hgros_schema_known(
        type_name: *const c_char,
        schema: *mut *mut hgros_schema,
    ) -> hgros_status;
    pub fn hgros_schema_free(schema: *mut hgros_schema);
    pub fn hgros_schema_type_name(schema: *const hgros_schema) -> *const c_char;
    pub fn hgros_schema_encoding(schema: *const hgros_schema) -> i32;
    pub fn hgros_schema_fingerprint(schema: *const hgros_schema) -> u64;
    pub fn hgros_schema_descriptor_set(
        schema: *const hgros_schema,
        size: *mut usize,
    ) -> *const c_void;

    pub fn hgros_message_data(message: *const hgros_message, size: *mut usize) -> *const c_void;
    pub fn hgros_message_schema(message: *const hgros_message) -> *const hgros_schema;
    pub fn hgros_message_get_info(
        message: *const hgros_message,
        info: *mut hgros_message_info,
    ) -> hgros_status;
    pub fn hgros_message_keep(
        message: *const hgros_message,
        kept: *mut *mut hgros_message,
    ) -> hgros_status;
    pub fn hgros_message_free(message: *mut hgros_message);
    pub fn hgros_message_leases() -> u64;

    pub fn hgros_publisher_open(
        session: *mut hgros_session,
        channel: *const c_char,
        schema: *const hgros_schema,
        options: *const hgros_publish_options,
        publisher: *mut *mut hgros_publisher,
    ) -> hgros_status;
    pub fn hgros_publisher_close(publisher: *mut hgros_publisher);
    pub fn hgros_publish_wait(
        publisher: *const hgros_publisher,
        data: *const c_void,
        size: usize,
        timeout_ns: i64,
    ) -> hgros_status;
    pub fn hgros_loan_open(
        publisher: *const hgros_publisher,
        size: usize,
        loan: *mut *mut hgros_loan,
    ) -> hgros_status;
    pub fn hgros_loan_data(loan: *mut hgros_loan, size: *mut usize) -> *mut c_void;
    pub fn hgros_loan_publish(loan: *mut hgros_loan, timeout_ns: i64) -> hgros_status;
    pub fn hgros_loan_free(loan: *mut hgros_loan);

    pub fn hgros_subscribe(
        session: *mut hgros_session,
        channel: *const c_char,
        options: *const hgros_subscribe_options,
        callback: Option<hgros_message_callback>,
        user: *mut c_void,
        release: Option<hgros_release>,
        subscription: *mut *mut hgros_subscription,
    ) -> hgros_status;
    pub fn hgros_subscribe_queue(
        session: *mut hgros_session,
        channel: *const c_char,
        options: *const hgros_subscribe_options,
        subscription: *mut *mut hgros_subscription,
    ) -> hgros_status;
    pub fn hgros_queue_take(
        queue: *mut hgros_subscription,
        timeout_ns: i64,
        message: *mut *mut hgros_message,
    ) -> hgros_status;
    pub fn hgros_queue_descriptor(queue: *const hgros_subscription) -> i32;
    pub fn hgros_subscription_get_stats(
        subscription: *const hgros_subscription,
        stats: *mut hgros_subscription_stats,
    ) -> hgros_status;
    pub fn hgros_subscription_end(subscription: *mut hgros_subscription);
    pub fn hgros_subscription_close(subscription: *mut hgros_subscription);

    pub fn hgros_reply_set(
        reply: *mut hgros_reply,
        data: *const c_void,
        size: usize,
    ) -> hgros_status;
    pub fn hgros_reply_fail(reply: *mut hgros_reply, sentence: *const c_char) -> hgros_status;
    pub fn hgros_serve(
        session: *mut hgros_session,
        name: *const c_char,
        request: *const hgros_schema,
        reply: *const hgros_schema,
        options: *const hgros_serve_options,
        handler: Option<hgros_service_handler>,
        user: *mut c_void,
        release: Option<hgros_release>,
        service: *mut *mut hgros_service,
    ) -> hgros_status;
    pub fn hgros_service_close(service: *mut hgros_service);
    pub fn hgros_call(
        session: *mut hgros_session,
        name: *const c_char,
        request_schema: *const hgros_schema,
        data: *const c_void,
        size: usize,
        reply_schema: *const hgros_schema,
        timeout_ns: i64,
        reply: *mut *mut hgros_message,
    ) -> hgros_status;

    pub fn hgros_params_open(
        session: *mut hgros_session,
        files: *const *const c_char,
        count: usize,
        params: *mut *mut hgros_params,
    ) -> hgros_status;
    pub fn hgros_params_of(
        session: *mut hgros_session,
        name: *const c_char,
        timeout_ns: i64,
        params: *mut *mut hgros_params,
    ) -> hgros_status;
    pub fn hgros_params_close(params: *mut hgros_params) -> hgros_status;
    pub fn hgros_params_declare(
        params: *mut hgros_params,
        path: *const c_char,
        kind: i32,
        fallback: *const c_char,
        info: *const hgros_param_info,
    ) -> hgros_status;
    pub fn hgros_params_get_bool(
        params: *mut hgros_params,
        path: *const c_char,
        value: *mut i32,
    ) -> hgros_status;
    pub fn hgros_params_get_integer(
        params: *mut hgros_params,
        path: *const c_char,
        value: *mut i64,
    ) -> hgros_status;
    pub fn hgros_params_get_number(
        params: *mut hgros_params,
        path: *const c_char,
        value: *mut f64,
    ) -> hgros_status;
    pub fn hgros_params_get_text(
        params: *mut hgros_params,
        path: *const c_char,
        value: *mut *mut c_char,
    ) -> hgros_status;
    pub fn hgros_params_get(
        params: *mut hgros_params,
        path: *const c_char,
        yaml: *mut *mut c_char,
    ) -> hgros_status;
    pub fn hgros_params_set_bool(
        params: *mut hgros_params,
        path: *const c_char,
        value: i32,
    ) -> hgros_status;
    pub fn hgros_params_set_integer(
        params: *mut hgros_params,
        path: *const c_char,
        value: i64,
    ) -> hgros_status;
    pub fn hgros_params_set_number(
        params: *mut hgros_params,
        path: *const c_char,
        value: f64,
    ) -> hgros_status;
    pub fn hgros_params_set_text(
        params: *mut hgros_params,
        path: *const c_char,
        value: *const c_char,
    ) -> hgros_status;
    pub fn hgros_params_set(
        params: *mut hgros_params,
        path: *const c_char,
        yaml: *const c_char,
    ) -> hgros_status;
    pub fn hgros_params_remove(params: *mut hgros_params, path: *const c_char) -> hgros_status;
    pub fn hgros_params_save(params: *mut hgros_params) -> hgros_status;
    pub fn hgros_params_watch(
        params: *mut hgros_params,
        path: *const c_char,
        callback: Option<hgros_param_callback>,
        user: *mut c_void,
        release: Option<hgros_release>,
        watch: *mut *mut hgros_watch,
    ) -> hgros_status;

    pub fn hgros_transforms_open(
        session: *mut hgros_session,
        transforms: *mut *mut hgros_transforms,
    ) -> hgros_status;
    pub fn hgros_transforms_close(transforms: *mut hgros_transforms) -> hgros_status;
    pub fn hgros_transforms_set(
        transforms: *mut hgros_transforms,
        parent: *const c_char,
        child: *const c_char,
        pose: *const hgros_transform,
    ) -> hgros_status;
    pub fn hgros_transforms_set_static(
        transforms: *mut hgros_transforms,
        parent: *const c_char,
        child: *const c_char,
        pose: *const hgros_transform,
    ) -> hgros_status;
    pub fn hgros_transforms_lookup(
        transforms: *mut hgros_transforms,
        target: *const c_char,
        source: *const c_char,
        found: *mut hgros_transform,
    ) -> hgros_status;
    pub fn hgros_transforms_lookup_at(
        transforms: *mut hgros_transforms,
        target: *const c_char,
        source: *const c_char,
        time_ns: i64,
        found: *mut hgros_transform,
    ) -> hgros_status;
    pub fn hgros_transforms_wait(
        transforms: *mut hgros_transforms,
        target: *const c_char,
        source: *const c_char,
        time_ns: i64,
        timeout_ns: i64,
        found: *mut hgros_transform,
    ) -> hgros_status;

    pub fn hgros_peers_open(
        session: *const hgros_session,
        peers: *mut *mut hgros_peers,
    ) -> hgros_status;
    pub fn hgros_peers_count(peers: *const hgros_peers) -> usize;
    pub fn hgros_peers_get(
        peers: *const hgros_peers,
        index: usize,
        peer: *mut hgros_peer,
    ) -> hgros_status;
    pub fn hgros_peers_free(peers: *mut hgros_peers);
    pub fn hgros_channels_open(
        session: *mut hgros_session,
        channels: *mut *mut hgros_channels,
    ) -> hgros_status;
    pub fn hgros_channels_count(channels: *const hgros_channels) -> usize;
    pub fn hgros_channels_get(
        channels: *const hgros_channels,
        index: usize,
        channel: *mut hgros_channel,
    ) -> hgros_status;
    pub fn hgros_channels_free(channels: *mut hgros_channels);
    pub fn hgros_watch_close(watch: *mut hgros_watch);
    pub fn hgros_watch_peers(
        session: *mut hgros_session,
        callback: Option<hgros_peer_callback>,
        user: *mut c_void,
        release: Option<hgros_release>,
        watch: *mut *mut hgros_watch,
    ) -> hgros_status;
}
