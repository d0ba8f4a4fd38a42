package org.hgros;

/** Describes a parameter that is declared. */
public final class ParamInfo {
  String description;
  String unit;
  boolean readOnly;
  Double least;
  Double most;
  String[] choices = {};

  public ParamInfo description(String description) {
    this.description = description;
    return this;
  }

  public ParamInfo unit(String unit) {
    this.unit = unit;
    return this;
  }

  /** It keeps the value from the start of the program. */
  public ParamInfo readOnly() {
    readOnly = true;
    return this;
  }

  /** The least value of a number, or of each number of a list. */
  public ParamInfo least(double value) {
    least = value;
    return this;
  }

  /** The greatest value of a number, or of each number of a list. */
  public ParamInfo most(double value) {
    most = value;
    return this;
  }

  /** The values that a text may have. */
  public ParamInfo choices(String... texts) {
    choices = texts.clone();
    return this;
  }
}
