package hgros

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"encoding/json"
	"fmt"
	"reflect"
	"runtime/cgo"
	"time"
	"unsafe"
)

// Params is a tree of parameters. A path is written like slam.matcher.gains[2].
type Params struct {
	guard
	handle  *C.hgros_params
	session *Session
}

// Params reads the parameters of this program from YAML files, later ones over earlier ones. Other sessions may read,
// watch and set them under the session's name.
func (s *Session) Params(files ...string) (*Params, error) {
	if err := uncut("The path of a file", files...); err != nil {
		return nil, err
	}
	list, release := textList(files)
	defer release()
	params := &Params{session: s}
	err := s.do("session", func() C.hgros_status {
		return C.hgros_params_open(s.handle, list, C.size_t(len(files)), &params.handle)
	})
	if err != nil {
		return nil, err
	}
	return params, nil
}

// ParamsOf are the parameters that a session offers under its name. Each function asks that session, and waits at most
// the timeout.
func (s *Session) ParamsOf(name string, timeout time.Duration) (*Params, error) {
	if err := uncut("The name of the other session", name); err != nil {
		return nil, err
	}
	text := C.CString(name)
	defer C.free(unsafe.Pointer(text))
	params := &Params{session: s}
	err := s.do("session", func() C.hgros_status {
		return C.hgros_params_of(s.handle, text, C.int64_t(timeout), &params.handle)
	})
	if err != nil {
		return nil, err
	}
	return params, nil
}

// Close ends the parameters; those of a closed session may be closed, too. Inside a callback of the session or of the
// parameters it does not wait for it: the rest is done once the callback has returned.
func (p *Params) Close() error {
	return p.closeWith(func() C.hgros_status { return C.hgros_params_close(p.handle) })
}

// ParamInfo describes a parameter that is declared. nil is no description and no bounds.
type ParamInfo struct {
	Description string
	Unit        string
	ReadOnly    bool     // Keeps the value from the start of the program.
	Least, Most *float64 // Bounds of numbers, included.
	Choices     []string // For a text.
}

// Declare gives a parameter its kind, bounds, and the value that it has if it was never set: a bool, int, int64,
// float64, string or []float64.
func (p *Params) Declare(path string, fallback any, info *ParamInfo) error {
	var kind C.int32_t
	switch fallback.(type) {
	case bool:
		kind = C.HGROS_PARAM_BOOL
	case int, int64:
		kind = C.HGROS_PARAM_INTEGER
	case float64:
		kind = C.HGROS_PARAM_NUMBER
	case string:
		kind = C.HGROS_PARAM_TEXT
	case []float64:
		kind = C.HGROS_PARAM_NUMBERS
	default:
		return badValue(path, fallback)
	}
	yaml, err := json.Marshal(fallback) // Which is YAML, too.
	if err != nil {
		return badValue(path, fallback)
	}
	if info == nil {
		info = &ParamInfo{}
	}
	if text, ok := fallback.(string); ok {
		if err := uncut("The value of a parameter", text); err != nil {
			return err
		}
	}
	given := append([]string{path, info.Description, info.Unit}, info.Choices...)
	if err := uncut("A text of a parameter", given...); err != nil {
		return err
	}
	choices, release := textList(info.Choices)
	defer release()
	chosen := (*C.hgros_param_info)(C.calloc(1, C.sizeof_hgros_param_info))
	defer C.free(unsafe.Pointer(chosen))
	chosen.size = C.sizeof_hgros_param_info
	chosen.read_only = truth(info.ReadOnly)
	texts, free := textList([]string{path, string(yaml), info.Description, info.Unit})
	defer free()
	text := unsafe.Slice(texts, 4)
	chosen.description, chosen.unit = text[2], text[3]
	if info.Least != nil {
		chosen.has_least, chosen.least = 1, C.double(*info.Least)
	}
	if info.Most != nil {
		chosen.has_most, chosen.most = 1, C.double(*info.Most)
	}
	if len(info.Choices) > 0 {
		chosen.choices, chosen.choice_count = choices, C.size_t(len(info.Choices))
	}
	return p.do("parameters", func() C.hgros_status {
		return C.hgros_params_declare(p.handle, text[0], kind, text[1], chosen)
	})
}

func badValue(path string, value any) error {
	shown := ""
	if kind := reflect.ValueOf(value).Kind(); kind <= reflect.Complex128 || kind == reflect.String {
		shown = fmt.Sprintf(" %v", value) // What may contain itself is not shown: its text has no end.
	}
	return &Error{InvalidArgument, fmt.Sprintf("The value%s of parameter \"%s\" is a %T, but must be a bool, int, "+
		"int64, finite float64, string or []float64.", shown, path, value)}
}

func (p *Params) at(path string, call func(path *C.char) C.hgros_status) error {
	if err := uncut("The path of a parameter", path); err != nil {
		return err
	}
	text := C.CString(path)
	defer C.free(unsafe.Pointer(text))
	return p.do("parameters", func() C.hgros_status { return call(text) })
}

// Bool reads a value.
func (p *Params) Bool(path string) (bool, error) {
	var value C.int32_t
	err := p.at(path, func(path *C.char) C.hgros_status { return C.hgros_params_get_bool(p.handle, path, &value) })
	return value != 0, err
}

// Integer reads a value.
func (p *Params) Integer(path string) (int64, error) {
	var value C.int64_t
	err := p.at(path, func(path *C.char) C.hgros_status { return C.hgros_params_get_integer(p.handle, path, &value) })
	return int64(value), err
}

// Number reads a value.
func (p *Params) Number(path string) (float64, error) {
	var value C.double
	err := p.at(path, func(path *C.char) C.hgros_status { return C.hgros_params_get_number(p.handle, path, &value) })
	return float64(value), err
}

// Text reads a value.
func (p *Params) Text(path string) (string, error) {
	var value *C.char
	err := p.at(path, func(path *C.char) C.hgros_status { return C.hgros_params_get_text(p.handle, path, &value) })
	defer C.hgros_text_free(value)
	return C.GoString(value), err
}

// YAML reads any value. An empty path is the whole tree.
func (p *Params) YAML(path string) (string, error) {
	var value *C.char
	err := p.at(path, func(path *C.char) C.hgros_status { return C.hgros_params_get(p.handle, path, &value) })
	defer C.hgros_text_free(value)
	return C.GoString(value), err
}

// Set sets a value: a bool, int, int64, float64, string or []float64.
func (p *Params) Set(path string, value any) error {
	switch chosen := value.(type) {
	case int:
		return p.Set(path, int64(chosen))
	case bool:
		return p.at(path, func(path *C.char) C.hgros_status {
			return C.hgros_params_set_bool(p.handle, path, truth(chosen))
		})
	case int64:
		return p.at(path, func(path *C.char) C.hgros_status {
			return C.hgros_params_set_integer(p.handle, path, C.int64_t(chosen))
		})
	case float64:
		return p.at(path, func(path *C.char) C.hgros_status {
			return C.hgros_params_set_number(p.handle, path, C.double(chosen))
		})
	case string:
		if err := uncut("The value of a parameter", chosen); err != nil {
			return err
		}
		text := C.CString(chosen)
		defer C.free(unsafe.Pointer(text))
		return p.at(path, func(path *C.char) C.hgros_status {
			return C.hgros_params_set_text(p.handle, path, text)
		})
	case []float64:
		if yaml, err := json.Marshal(chosen); err == nil {
			return p.SetYAML(path, string(yaml))
		}
	}
	return badValue(path, value)
}

// SetYAML sets a value as YAML, such as "{x: 1}".
func (p *Params) SetYAML(path, yaml string) error {
	if err := uncut("The value of a parameter", yaml); err != nil {
		return err
	}
	text := C.CString(yaml)
	defer C.free(unsafe.Pointer(text))
	return p.at(path, func(path *C.char) C.hgros_status { return C.hgros_params_set(p.handle, path, text) })
}

// Remove removes a value; a declared parameter returns to its fallback.
func (p *Params) Remove(path string) error {
	return p.at(path, func(path *C.char) C.hgros_status { return C.hgros_params_remove(p.handle, path) })
}

// Watch is something that is watched until it or its session is closed.
type Watch struct {
	guard
	handle  *C.hgros_watch
	session *Session
}

func (s *Session) watch(handle *C.hgros_watch) *Watch {
	watch := &Watch{handle: handle, session: s}
	watch.free = func() { C.hgros_watch_close(handle) }
	s.keep(watch)
	return watch
}

// Close ends the watch: no call comes after it. Outside callbacks it waits for the running one.
func (w *Watch) Close() {
	w.session.forget(w)
	w.close()
}

// OnChange calls a function for each changed value at, below or above a path, with its YAML, or "" if it was removed.
// It runs on the thread that makes the change; for another session on a worker, first with all current values.
func (p *Params) OnChange(path string, changed func(path, yaml string)) (*Watch, error) {
	if changed == nil {
		return nil, &Error{InvalidArgument, "The function for changes of \"" + path + "\" is nil."}
	}
	var watch *C.hgros_watch
	err := p.at(path, func(path *C.char) C.hgros_status {
		return C.GoParamsWatch(p.handle, path, C.uintptr_t(cgo.NewHandle(changed)), &watch)
	})
	if err != nil {
		return nil, err
	}
	return p.session.watch(watch), nil
}

//export hgrosGoChanged
func hgrosGoChanged(user C.uintptr_t, path, yaml *C.char) {
	cgo.Handle(user).Value().(func(string, string))(C.GoString(path), C.GoString(yaml))
}

// textList is texts in memory of C, until release.
func textList(texts []string) (list **C.char, release func()) {
	memory := C.calloc(C.size_t(len(texts)+1), C.size_t(unsafe.Sizeof((*C.char)(nil))))
	list = (**C.char)(memory)
	entries := unsafe.Slice(list, len(texts)+1)
	for i, text := range texts {
		entries[i] = C.CString(text)
	}
	return list, func() {
		for _, entry := range entries {
			C.free(unsafe.Pointer(entry))
		}
		C.free(memory)
	}
}

func textsOf(list **C.char, count int) []*C.char { return unsafe.Slice(list, count) }
