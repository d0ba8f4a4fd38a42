package org.hgros;

/**
 * Makes the reply to a request. What it throws becomes the caller's {@link Code#HANDLER_FAILED}, with the same
 * sentence.
 */
@FunctionalInterface
public interface ServiceHandler<Q, R> {
  R handle(Q request) throws Exception;
}
